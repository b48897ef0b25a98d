#include "photon/optics/phase.h"

namespace obscura {
namespace {

// By value: std::clamp, which takes references, goes through memory.
double clamp_cosine(double cosine) noexcept { return cosine > 1 ? 1.0 : cosine < -1 ? -1.0 : cosine; }

}  // namespace

PhaseFunction PhaseFunction::blunted(double peak) const {
  return std::visit([peak](const auto& phase) { return PhaseFunction(phase.blunted(peak)); }, any_);
}

double PhaseFunction::value(double cosine) const noexcept {
  return std::visit([mu = clamp_cosine(cosine)](const auto& phase) { return phase.value(mu); }, any_);
}

double PhaseFunction::sample(double u1, double u2) const noexcept {
  return std::visit([u1, u2](const auto& phase) { return clamp_cosine(phase.sample(u1, u2)); }, any_);
}

double PhaseFunction::sample_one_minus(double u1, double u2) const noexcept {
  return std::visit([u1, u2](const auto& phase) { return phase.sample_one_minus(u1, u2); }, any_);
}

double PhaseFunction::largest() const noexcept {
  return std::visit([](const auto& phase) { return phase.largest(); }, any_);
}

double PhaseFunction::mean_cosine() const noexcept {
  return std::visit([](const auto& phase) { return phase.mean_cosine(); }, any_);
}

double PhaseFunction::moment(int l) const {
  return std::visit([l](const auto& phase) { return phase.moment(l); }, any_);
}

}  // namespace obscura
