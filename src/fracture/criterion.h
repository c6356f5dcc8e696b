// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "common/real.h"
#include "fracture/equivalent_stress.h"
#include "input/model.h"
#include "mechanics/tetrahedron_field.h"

#include <cstddef>
#include <cstdint>
#include <memory>
#include <optional>
#include <span>
#include <utility>
#include <vector>

namespace crackle::fracture {

/// Fracture criterion: the equivalent stress, the strength with which it is compared, and the memory of each
/// tetrahedron.
///
/// Under slowly growing load a tetrahedron breaks as soon as its equivalent stress reaches the strength, so
/// quasi-static loading needs no memory between breaks. In a dynamic phase advance() decides at the end of
/// each step.
class Criterion {
public:
  /// @param strengths of each tetrahedron [Pa]
  Criterion(std::unique_ptr<const EquivalentStress> stress, std::vector<double> strengths)
      : stress_(std::move(stress)), strengths_(std::move(strengths)) {}
  virtual ~Criterion() = default;
  Criterion(const Criterion&) = delete;
  Criterion& operator=(const Criterion&) = delete;

  const EquivalentStress& stress() const { return *stress_; }

  /// The equivalent stress below which the tetrahedron never breaks, and at which it breaks under slowly
  /// growing load [Pa].
  double strength(std::size_t tetrahedron) const { return strengths_[tetrahedron]; }
  std::span<const double> strengths() const { return strengths_; }

  /// Replaces the strength of a tetrahedron that has not softened [Pa].
  void set_strength(std::size_t tetrahedron, double strength) { strengths_[tetrahedron] = strength; }

  /// From now on the tetrahedron gives way at this multiple of its initial strength, without delay, since the
  /// criterion has already been met once.
  void soften(std::size_t tetrahedron, double threshold) {
    if (first_strengths_.empty()) {
      first_strengths_ = strengths_;
      is_softened_.resize(strengths_.size(), 0);
    }
    strengths_[tetrahedron] = threshold * first_strengths_[tetrahedron];
    is_softened_[tetrahedron] = 1;
  }
  bool is_softened(std::size_t tetrahedron) const {
    return !is_softened_.empty() && is_softened_[tetrahedron] != 0;
  }

  /// Advances by one time step, in which the equivalent stress changed from `before` to `after`. Called for
  /// unbroken tetrahedra above the screening share of their strength at either end.
  /// @param earlier one step before `before`
  /// @return true if the tetrahedron breaks, or softens further, at the end of this step
  bool advance(std::size_t tetrahedron, double earlier, double before, double after) {
    // Breaks at the end of the step that is closest to the crossing.
    if (is_softened(tetrahedron)) return after + (after - before) / 2 > strengths_[tetrahedron];
    return integrate(tetrahedron, earlier, before, after);
  }

  /// The share of its strength above which a tetrahedron must be passed to advance() at the end of a step.
  /// @param stable_step time for a wave to cross the smallest tetrahedra [s]
  virtual double screening_share([[maybe_unused]] double stable_step) const { return 1; }

  /// Time to failure under constant stress, ignoring the past [s]; infinity if the strength is exceeded by
  /// rounding only.
  double time_to_failure(std::size_t tetrahedron, double stress) const {
    if (!is_over(tetrahedron, stress)) return infinity;
    return is_softened(tetrahedron) ? 0 : delay(tetrahedron, stress);
  }

  /// State of each tetrahedron, initially 0; empty for a criterion without memory. Stored in checkpoints.
  std::span<const double> memory() const { return memory_; }
  void set_memory(std::size_t tetrahedron, double value) { memory_[tetrahedron] = value; }

protected:
  /// advance() for an intact tetrahedron.
  virtual bool integrate(std::size_t tetrahedron, double earlier, double before, double after) = 0;
  /// time_to_failure() for an intact tetrahedron above its strength.
  virtual double delay(std::size_t tetrahedron, double stress) const = 0;

  /// True if a stress exceeds the strength by more than the rounding of a stress computed from 32-bit
  /// displacements.
  bool is_over(std::size_t tetrahedron, double stress) const {
    constexpr double rounding = 1e-5;
    return stress > strengths_[tetrahedron] * (1 + rounding);
  }

  std::unique_ptr<const EquivalentStress> stress_;
  std::vector<double> strengths_;
  std::vector<double> memory_;

private:
  std::vector<double> first_strengths_;    // empty as long as nothing has softened
  std::vector<std::uint8_t> is_softened_;  // likewise
};

/// Makes the criterion selected by the input, with the stress that it selects.
/// @param strengths sigma_0 of each tetrahedron, or strengths derived from the input's toughness [Pa]
/// @param time_step with which advance() will be called [s]
/// @param impulses K_f of each tetrahedron [Pa^beta s]
std::unique_ptr<Criterion> make_criterion(const input::Fracture& fracture, std::vector<double> strengths,
                                          double time_step, mechanics::TetrahedronField<double> impulses);

}  // namespace crackle::fracture
