// What several keys of one object mean together.
#include <fmt/format.h>

#include <cmath>

#include "octree/io/volume_formats.h"
#include "scene/file/scene_keys.h"
#include "scene/file/scene_reader.h"
#include "scene/file/scene_table_io.h"
#include "sensor/picture/image_io.h"

namespace obscura::detail {

void ObjectReader::phase_table(const PhaseTableDescription& given, PhaseFunction& function) {
  if (!in_form_) return;
  afterwards_.emplace_back([this, given, &function] {
    Table table{{given.angle_deg, given.value}, {}, {}};
    if (!given.file.empty() && !given.value.empty()) {
      findings_.problem(pointer_to(pointer_, "value"), "\"file\" and a table are both given", "give one of them");
      return;
    }
    if (!given.file.empty()) table = read_table(given.file, {"angle_deg", "value"});
    if (!table.problem.empty()) {
      findings_.problem(pointer_to(pointer_, "file"), table.problem, table.hint);
      return;
    }
    try {
      double norm_change = 0;
      function = PhaseFunction(TablePhase(table.columns[0], table.columns[1], &norm_change));
      if (std::abs(norm_change) > 0.01) {
        findings_.warn(
            fmt::format("{}: the integral over the sphere is {:.4g}; normalised to 1", pointer_, 1 + norm_change));
      }
    } catch (const InputError& error) {
      for (const Problem& p : error.problems()) {
        findings_.problem(pointer_, p.problem, p.hint.empty() ? "give a value above or at 0 for each angle" : p.hint);
      }
    }
  });
}

void ObjectReader::periods(const std::vector<Axis>& axes, const std::vector<double>& periods, CloudDescription& cloud) {
  for (const Axis axis : axes) cloud.periodic[axis == Axis::x ? 0 : 1] = true;
  const std::string where = pointer_to(pointer_, "periodic");
  const std::string period = pointer_to(pointer_, "period_m");
  if (axes.size() > 2 || (axes.size() == 2 && axes[0] == axes[1])) {
    findings_.problem(where, "the same axis is given twice", "name each axis once");
    return;
  }
  if (!periods.empty() && !find("periodic")) {
    findings_.problem(period, "a period is given, but no axis is periodic", "add \"periodic\": [\"x\", \"y\"]");
    return;
  }
  if (axes.empty()) return;
  if (!find("period_m")) {
    const VolumeFormat* format = cloud.grid ? volume_format_of(cloud.grid->file) : nullptr;
    if (format && !format->tells_lattice_size) {
      findings_.problem(period,
                        fmt::format("\"period_m\" is missing: a {} file does not say where a period ends",
                                    lower_extension(cloud.grid->file)),
                        "give one period for each periodic axis");
    }
  } else if (findings_.good(period) && periods.size() != axes.size()) {
    findings_.problem(period, fmt::format("{} periods for {} periodic axes", periods.size(), axes.size()),
                      "give one for each, in the order of \"periodic\"");
  } else if (findings_.good(period)) {
    for (std::size_t i = 0; i < axes.size(); ++i) cloud.period_m[axes[i] == Axis::x ? 0 : 1] = periods[i];
  }
}

void ObjectReader::angle_factor(const std::vector<double>& angle_deg, const std::vector<double>& factor,
                                MaterialDescription& material) {
  const std::string pointer = pointer_to(pointer_, "emissivity_by_angle");
  if (!findings_.good(pointer)) return;
  if (angle_deg.size() != factor.size()) {
    findings_.problem(pointer, fmt::format("{} angles but {} factors", angle_deg.size(), factor.size()),
                      "give one factor for each angle");
    return;
  }
  material.angle_deg = angle_deg;
  material.angle_factor = factor;
}

void ObjectReader::point_spread(const std::filesystem::path& file, DetectorSettings& detector) {
  const std::string pointer = pointer_to(pointer_, "psf_file");
  if (!findings_.good(pointer)) return;
  if (detector.psf_sigma_px > 0) {
    findings_.problem(pointer, "\"psf_sigma_px\" and \"psf_file\" are both given", "give one of them");
    return;
  }
  try {
    detector.psf = point_spread_of(read_image(file));
  } catch (const InputError& error) {
    const Problem& p = error.problems().front();
    findings_.problem(pointer, fmt::format("\"{}\" cannot be read as a point spread: {}", file.string(), p.problem),
                      p.hint);
  }
}

void ObjectReader::particles(const ParticlesDescription& description, std::vector<ParticleDescription>& particles) {
  const std::string pointer = pointer_to(pointer_to(pointer_, "particles"), "file");
  const Table table = read_table(description.file, {"s", "x_m", "y_m", "z_m", "radius_m", "K"});
  if (!table.problem.empty()) {
    findings_.problem(pointer, table.problem, table.hint);
    return;
  }
  const auto& c = table.columns;
  for (std::size_t i = 0; i < c[0].size(); ++i) {
    if (!(c[4][i] > 0) || !(c[5][i] >= 0)) {
      findings_.problem(
          pointer,
          fmt::format("{}: row {} has radius_m {:g} and K {:g}", description.file.string(), i + 1, c[4][i], c[5][i]),
          "radius_m has to be above 0, K at least 0");
      return;
    }
    particles.push_back({c[0][i], Vec3d(c[1][i], c[2][i], c[3][i]), c[4][i], c[5][i]});
  }
}

}  // namespace obscura::detail
