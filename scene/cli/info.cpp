// obscura info: what a volume file holds and what its octrees cost.
#include <fmt/format.h>

#include <cmath>
#include <cstdio>
#include <memory>

#include "chords.h"
#include "commands.h"
#include "console.h"
#include "octree/build/build.h"
#include "octree/io/export.h"
#include "octree/io/import.h"
#include "octree/io/volume_formats.h"
#include "quantities.h"

namespace obscura::cli {
namespace {

struct InfoArguments {
  std::string file, tolerance = "0.001";
  bool quiet = false;
};

void print_transform(const Affine& m) {
  fmt::print("  to metres    ");
  for (int axis = 0; axis < 3; ++axis) {
    std::string sum;
    for (int from = 0; from < 3; ++from) {
      if (m[from][axis] != 0) sum += fmt::format("{}{:.6g} {}", sum.empty() ? "" : " + ", m[from][axis], "ijk"[from]);
    }
    const double shift = m[3][axis];
    if (sum.empty())
      sum = fmt::format("{:.6g}", shift);
    else if (shift != 0)
      sum += fmt::format(" {} {:.6g}", shift < 0 ? '-' : '+', std::abs(shift));
    fmt::print("{}{} = {}", axis == 0 ? "" : ",  ", "xyz"[axis], sum);
  }
  fmt::print("\n");
}

void print_grid(const GridInfo& grid) {
  fmt::print("\n{}{}  {}  {} x {} x {} voxels of {:.6g} x {:.6g} x {:.6g} m\n", grid.name,
             grid.units.empty() ? "" : " (" + grid.units + ")", grid.type, grid.resolution.x, grid.resolution.y,
             grid.resolution.z, grid.voxel_m.x, grid.voxel_m.y, grid.voxel_m.z);
  print_transform(grid.index_to_local);
  fmt::print("  values       {:.6g} to {:.6g} in {} voxels", grid.min, grid.max, grid.active);
  if (grid.tiles > 0) fmt::print(" ({} tiles)", grid.tiles);
  if (grid.background != 0) fmt::print(", {:.6g} in between", grid.background);
  fmt::print("\n");
  if (grid.times > 1) fmt::print("  times        {}; the first is read\n", grid.times);
}

void print_sizes(const std::string& kind, const OctreeStatistics& s, const OtherForms& others) {
  const auto against = [&](const char* what, std::uint64_t bytes) {
    if (bytes > 0) {
      fmt::print("; {:.3g} of {} ({})", static_cast<double>(s.bytes) / static_cast<double>(bytes), what,
                 bytes_text(bytes));
    }
  };
  fmt::print("  {:<12} {}", kind, bytes_text(s.bytes));
  against("dense", s.bytes_dense);
  against("OpenVDB", others.bytes_openvdb);
  against("NanoVDB", others.bytes_nanovdb);
  against("its Fp8", others.bytes_nanovdb_fp8);
  fmt::print("\n");
}

void print_leaves(const OctreeStatistics& s) {
  std::uint64_t all = 0;
  std::string levels;
  for (std::size_t level = 0; level < s.leaves.size(); ++level) {
    if (s.leaves[level] == 0) continue;
    all += s.leaves[level];
    levels += fmt::format("{}{}^3: {}", levels.empty() ? "" : ", ", std::uint64_t{1} << level, s.leaves[level]);
  }
  if (all == 0) {
    fmt::print("               no leaves: every value is 0\n");
    return;
  }
  fmt::print("               {} leaves ({} voxels); {:.3g} B a leaf\n", all, levels,
             static_cast<double>(s.bytes) / static_cast<double>(all));
}

int info(const InfoArguments& a) {
  const double tolerance = parse_tolerance(a.tolerance, "--tolerance");
  catch_interrupts();
  const std::vector<GridInfo> grids = inspect_volume(a.file);
  fmt::print("{}: {} grid{}\n", a.file, grids.size(), grids.size() == 1 ? "" : "s");
  for (const GridInfo& grid : grids) {
    print_grid(grid);
    if (!grid.scalar || !grid.affine) {
      fmt::print("  not read     {}\n", grid.scalar ? "its transform is not affine" : "it is not a scalar grid");
      continue;
    }
    if (cancel_flag()) break;
    Console console(a.quiet);
    const std::vector<VoxelStream> streams = open_volume(
        a.file, std::vector<GridRequest>{{grid.name, /*require_non_negative=*/false, /*fills_space=*/true}});
    const auto [lossless, report] = build_octree(streams.at(0), {.tolerance = 0, .measure = {}}, console.progress());
    console.finish();
    const OtherForms others = measure_other_forms(streams.at(0));
    print_sizes("lossless", lossless.statistics(), others);
    print_leaves(lossless.statistics());
    fmt::print("               built in {:.2f} s (NanoVDB's conversion: {:.2f} s)\n", report.seconds,
               others.seconds_nanovdb);
    if (!(tolerance > 0) || !(grid.min >= 0)) continue;
    const ErrorMeasure measure = assumed_measure(lossless);
    if (!(measure.optical_weight.front() > 0)) continue;
    const auto [merged, cost] =
        build_octree(streams.at(0), {.tolerance = tolerance, .measure = measure}, console.progress());
    console.finish();
    print_sizes(fmt::format("within {:g}", tolerance), merged.statistics(), others);
    print_leaves(merged.statistics());
    fmt::print(
        "               built in {:.2f} s; error of a ray's transmission {:.3g} measured on {} rays,\n"
        "               {:.3g} at most, where the thickest chord has optical depth {:g}\n",
        cost.seconds, cost.error_measured, cost.rays, cost.error_bound, kAssumedDepth);
  }
  return kDone;
}

}  // namespace

Command add_info(CLI::App& program) {
  const auto a = std::make_shared<InfoArguments>();
  CLI::App* app = program.add_subcommand("info", "Show what a volume file holds and what its octrees cost");
  app->add_option("file", a->file, volume_format_list())->required()->type_name("FILE");
  app->add_option("--tolerance", a->tolerance, "Error of a ray's transmission, 0.001 or 0.1%; 0: lossless only")
      ->type_name("E")
      ->capture_default_str();
  app->add_flag("--quiet", a->quiet, "No progress; errors stay");
  app->footer(fmt::format(
      "Without a scene no extinction is known: the thickest of 1000 chords is taken to have optical depth {:g}.\n\n"
      "Example:\n  obscura info cloud.vdb",
      kAssumedDepth));
  return {app, [a] { return info(*a); }};
}

}  // namespace obscura::cli
