// obscura convert: any volume that can be read, as OpenVDB, with a tolerance if one is given.
#include <fmt/format.h>

#include <algorithm>
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

struct ConvertArguments {
  std::string input, output, tolerance = "0";
  std::vector<std::string> grids;
  bool force = false, quiet = false;
};

// The grids to convert: those asked for, or all that can be read.
std::vector<GridRequest> requests_of(const ConvertArguments& a) {
  std::vector<GridRequest> requests;
  for (const std::string& name : a.grids) requests.push_back({name, false, true});
  if (!requests.empty()) return requests;
  for (const GridInfo& grid : inspect_volume(a.input)) {
    if (grid.scalar && grid.affine) requests.push_back({grid.name, false, true});
  }
  if (requests.empty()) throw InputError(a.input, "it holds no scalar grid", "see obscura info");
  return requests;
}

// Channels of one lattice; a .vdb of several would need as many conversions.
VoxelStream open_one_lattice(const ConvertArguments& a) {
  std::vector<VoxelStream> streams = open_volume(a.input, requests_of(a));
  if (streams.size() == 1) return std::move(streams.front());
  std::string lattices;
  for (const VoxelStream& stream : streams) {
    lattices += fmt::format("{}{}", lattices.empty() ? "" : "; ", fmt::join(stream.channels, ", "));
  }
  throw InputError(a.input, "its grids lie on different lattices: " + lattices,
                   "convert one at a time, with --grid NAME");
}

int convert(const ConvertArguments& a) {
  const double tolerance = parse_tolerance(a.tolerance, "--tolerance");
  const std::vector<Output> outputs = {{a.output, "OUT", ".vdb"}};
  check_outputs(outputs, a.force, {a.input});
  catch_interrupts();
  Console console(a.quiet);
  const VoxelStream stream = open_one_lattice(a);
  auto [octree, report] = build_octree(stream, {.tolerance = 0, .measure = {}}, console.progress());
  const std::uint64_t bytes_lossless = octree.statistics().bytes;
  if (tolerance > 0) {
    const ErrorMeasure measure = assumed_measure(octree);
    for (std::size_t channel = 0; channel < measure.optical_weight.size(); ++channel) {
      const std::string& name = octree.channels()[channel];
      if (const double extinction = measure.optical_weight[channel]; extinction > 0) {
        fmt::print("{}: taken as {:.6g} 1/m per unit, so that the thickest of 1000 chords has optical depth {:g}\n",
                   name, extinction, kAssumedDepth);
      } else {
        fmt::print("{}: cannot be an extinction; its values are kept\n", name);
      }
    }
    std::tie(octree, report) = build_octree(stream, {.tolerance = tolerance, .measure = measure}, console.progress());
  }
  console.finish();
  write_vdb(a.output, octree);
  const OctreeStatistics s = octree.statistics();
  fmt::print("octree: {} ({} lossless, {} dense)\n", bytes_text(s.bytes), bytes_text(bytes_lossless),
             bytes_text(s.bytes_dense));
  if (tolerance > 0) {
    fmt::print("error of a ray's transmission: {:.3g} measured on {} rays, {:.3g} at most\n", report.error_measured,
               report.rays, report.error_bound);
  } else {
    fmt::print("error: none; the values are the same\n");
  }
  fmt::print("{}: {}, {}\n", a.output, fmt::join(octree.channels(), ", "),
             bytes_text(std::filesystem::file_size(a.output)));
  return kDone;
}

}  // namespace

Command add_convert(CLI::App& program) {
  const auto a = std::make_shared<ConvertArguments>();
  CLI::App* app = program.add_subcommand("convert", "Convert a volume to OpenVDB, with a tolerance if one is given");
  app->add_option("input", a->input, volume_format_list())->required()->type_name("IN");
  app->add_option("output", a->output, "OpenVDB file to write")->required()->type_name("OUT.vdb");
  app->add_option("--tolerance", a->tolerance, "Error of a ray's transmission to allow, 0.001 or 0.1%; 0: lossless")
      ->type_name("E")
      ->capture_default_str();
  app->add_option("--grid", a->grids, "Grid to convert; may be repeated; default: all that are scalar")
      ->type_name("NAME")
      ->type_size(1)
      ->allow_extra_args(false)
      ->multi_option_policy(CLI::MultiOptionPolicy::TakeAll);
  app->add_flag("-f,--force", a->force, "Replace an output that exists");
  app->add_flag("--quiet", a->quiet, "No progress; errors stay");
  app->footer(
      fmt::format("Without a scene no extinction is known: each grid is taken as an extinction, scaled so that the\n"
                  "thickest of 1000 chords has optical depth {:g}.\n\n"
                  "Examples:\n"
                  "  obscura convert cloud.nc cloud.vdb\n"
                  "  obscura convert cloud.vdb small.vdb --tolerance 0.1% --grid density",
                  kAssumedDepth));
  return {app, [a] { return convert(*a); }};
}

}  // namespace obscura::cli
