#!/usr/bin/env bash
# Writes hills.asc, the terrain of smoke_at_night.json, to standard output: a plain before rolling hills.
awk 'BEGIN {
  n = 150; cell = 4; x0 = -250; y0 = -80
  printf "ncols %d\nnrows %d\nxllcorner %g\nyllcorner %g\ncellsize %g\nNODATA_value -9999\n", n, n, x0, y0, cell
  for (j = n - 1; j >= 0; --j) {
    for (i = 0; i < n; ++i) {
      x = x0 + (i + 0.5) * cell; y = y0 + (j + 0.5) * cell
      rise = y < 60 ? 0 : y > 260 ? 1 : (1 - cos((y - 60) * 3.14159265 / 200)) / 2
      hills = 24 + 9 * sin(0.013 * x + 1) + 6 * sin(0.031 * x - 0.017 * y) + 3 * sin(0.071 * x + 0.05 * y + 2) + 1.2 * sin(0.16 * x - 0.19 * y)
      plain = 0.25 * sin(0.09 * x + 0.3) * sin(0.11 * y) + 0.12 * sin(0.31 * x - 0.23 * y)
      printf "%.2f%s", rise * hills + plain, i == n - 1 ? "\n" : " "
    }
  }
}'
