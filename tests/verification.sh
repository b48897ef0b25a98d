#!/usr/bin/env bash
# Runs the tests that compare with the tables of tests/data/reference and writes what they reached to
# tests/VERIFICATION.md. The numbers are the same on any number of threads.
source "$(dirname "${BASH_SOURCE[0]}")/../.cmake/setup.sh"
build_project release -DOBSCURA_BUILD_TESTS=ON

rows=$(mktemp)
trap 'rm -f "$rows"' EXIT
export OBSCURA_VERIFICATION=$rows
failed=""
"$root/build/tests_photon" "[planck],[phase],[transfer]" > /dev/null || failed="$failed tests_photon"
"$root/build/tests_physics" "[ray],[reference]" > /dev/null || failed="$failed tests_physics"

{
  cat <<'TEXT'
# Verification

Written by `bash tests/verification.sh` from what the tests measure; how to read a row stands below the table.

| table | method | compared | numbers | demanded | reached |
|---|---|---|---|---|---|
TEXT
  LC_ALL=C sort "$rows" | sed 's/^/| /; s/$/ |/'
  cat <<'TEXT'

**Tables** are those of tests/data/reference. Each begins with what it holds; where its numbers come from, and which accuracy to trust and demand, stand in index.csv beside them and, in full, in the reference's own README.

| tables | source |
|---|---|
| a1 to a9, g1 to g5, f1 to f3, h1, h2, h4 | closed forms and quadratures of 40 to 50 digits |
| b1, b2 | Peierls' integral equation solved in two ways |
| c1 to c3 | exact solution of the infinite medium; exact moments |
| d1 to d3, d5, d7, h3 | doubling and adding, against eigenvalue discrete ordinates and cdisort 2.1.3 |
| d4 | Chandrasekhar's H function |
| d6 | DISORT's test problems 1 to 5, published and converged; their moments in f6 (Garcia and Siewert 1985) |
| e1 | I3RC Phase I case 1, Monte Carlo of 4e7 photons beside the published consensus |
| e2 to e4 | Monte Carlo with standard errors; e4 also by Peierls' equation |
| e5 | Kobayashi, Sugimura and Nagaya, Prog. Nucl. Energy 39, 119 (2001) |

**Reached.** "worst z": the largest deviation in standard errors of a number, with the root mean square over all, 1 where errors are told rightly. "SE up to": the largest relative standard error. "together": the deviation that all numbers have in common, weighted with their errors: the sharpest of all, for it knows a hundredth of what one number knows. "worst": the largest relative deviation. Discrete ordinates state an error of their own, from two grids and two orders.

**Demanded.** Statistical comparisons follow tests/support/agree.h: z below a limit with 1e-6 of false alarms shared among the comparisons, and a standard error below the one that is named. "SE < x % of the light": of what comes in. Even light: reflection and transmission of a beam as the radiance that leaves along it, by reciprocity; A by Kirchhoff: absorption as the emission of the same slab.

**What falls short of the tables' own accuracy.** Single numbers are not resolved to 0.1 % in the time that tests have, but for those of the rows that say so; tables as a whole are. The photon map's ball blurs light that falls off within it: its bias is in its rows, and falls with photons and with fewer neighbours. Spheres are made of voxels whose border costs what the rows of convergence say, most at the limb and for light that grazes thick spheres. Discrete ordinates leave out g > 0.85; thicker than 1,000 they miss the border where a beam ends by under 1 %, alike on two grids, so that their own error does not see it. c1 at w = 0, 0.999 and 1 and h2 at a depth of 1e6 are not run; of d5 at 1e3 and more only ordinates. Case ii of e5 is compared where the flux is above 0.05: deep in the shield no path finds the source in time.
TEXT
} > "$root/tests/VERIFICATION.md"
echo "wrote tests/VERIFICATION.md: $(wc -l < "$rows") comparisons"
[ -z "$failed" ] || { echo "failed:$failed" >&2; exit 1; }
