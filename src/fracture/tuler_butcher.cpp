// SPDX-License-Identifier: GPL-3.0-or-later
#include "fracture/tuler_butcher.h"

#include "fracture/equivalent_stress.h"

#include <algorithm>
#include <cmath>

namespace crackle::fracture {

namespace {

/// Maximum rise of stress at a crack front per stable step, relative to the strength. Faster ones break
/// slightly late.
constexpr double fastest_rise = 0.4;

}  // namespace

TulerButcher::TulerButcher(const input::Fracture& parameters, mechanics::TetrahedronField<double> impulses,
                           std::vector<double> strengths, double time_step)
    : Criterion(make_equivalent_stress(parameters), std::move(strengths)),
      exponent_(parameters.exponent),
      impulses_(std::move(impulses)),
      time_step_(time_step) {
  memory_.resize(strengths_.size(), 0.0);
}

bool TulerButcher::integrate(std::size_t tetrahedron, double earlier, double before, double after) {
  const double from = before - strengths_[tetrahedron], to = after - strengths_[tetrahedron];
  double& integral = memory_[tetrahedron];
  integral += time_step_ * mean_rate(from, to);
  const double next = to + (after - before) / 2 + 3 * ((after - before) - (before - earlier)) / 8;
  return integral + time_step_ / 2 * mean_rate(to, next) >= impulses_[static_cast<std::int32_t>(tetrahedron)];
}

double TulerButcher::screening_share(double stable_step) const {
  return 1 - fastest_rise * time_step_ / (2 * stable_step);
}

double TulerButcher::delay(std::size_t tetrahedron, double stress) const {
  const double over = stress - strengths_[tetrahedron];
  return impulses_[static_cast<std::int32_t>(tetrahedron)] / mean_rate(over, over);
}

/// Mean of max(x, 0)^beta while x goes linearly from one value to the other.
double TulerButcher::mean_rate(double from, double to) const {
  const double low = std::min(from, to), high = std::max(from, to);
  if (!(high > 0)) return 0;
  const double share = low < 0 ? high / (high - low) : 1;  // of the time with x > 0
  const double ratio = std::max(low, 0.0) / high;
  if (exponent_ == 2) return share * high * high * ((1 + ratio + ratio * ratio) / 3);
  // (1 - ratio^n) / (1 - ratio), without cancellation
  const double n = exponent_ + 1;
  const double sum = ratio == 1 ? n : std::expm1(n * std::log(ratio)) / (ratio - 1);
  return share * std::pow(high, exponent_) * (sum / n);
}

OneStepTulerButcher::OneStepTulerButcher(const input::Fracture& parameters,
                                         const mechanics::TetrahedronField<double>& impulses,
                                         std::vector<double> strengths, double time_step)
    : Criterion(make_equivalent_stress(parameters), std::move(strengths)), time_step_(time_step) {
  if (parameters.toughness > 0 && !parameters.softens()) return;
  for (std::size_t t = 0; t < strengths_.size(); ++t)
    strengths_[t] += std::pow(impulses[static_cast<std::int32_t>(t)] / time_step, 1 / parameters.exponent);
}

std::unique_ptr<Criterion> make_criterion(const input::Fracture& fracture, std::vector<double> strengths,
                                          double time_step, mechanics::TetrahedronField<double> impulses) {
  switch (fracture.accumulation) {
    case input::Accumulation::step:
      return std::make_unique<OneStepTulerButcher>(fracture, impulses, std::move(strengths), time_step);
    case input::Accumulation::cumulative:
      return std::make_unique<TulerButcher>(fracture, std::move(impulses), std::move(strengths), time_step);
  }
  return nullptr;
}

}  // namespace crackle::fracture
