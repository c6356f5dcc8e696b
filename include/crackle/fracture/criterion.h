// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "crackle/common/real.h"
#include "crackle/fracture/equivalent_stress.h"
#include "crackle/input/parameters.h"

#include <cstddef>
#include <cstdint>
#include <memory>
#include <span>
#include <utility>
#include <vector>

namespace crackle::fracture {

/// When tetrahedra break: what is watched of their stress, the strength it is compared with, and what each
/// remembers of its past.
///
/// Under slowly growing load a tetrahedron breaks as soon as its equivalent stress reaches the strength; so
/// there is nothing to remember between two breaks of quasi-static loading. In a dynamic phase advance()
/// decides at the end of each step.
class Criterion {
public:
  /// @param strengths of each tetrahedron [Pa]
  Criterion(std::unique_ptr<const EquivalentStress> stress, std::vector<double> strengths)
      : stress_(std::move(stress)), strengths_(std::move(strengths)) {}
  virtual ~Criterion() = default;
  Criterion(const Criterion&) = delete;
  Criterion& operator=(const Criterion&) = delete;

  const EquivalentStress& stress() const { return *stress_; }

  /// The equivalent stress up to which the tetrahedron never breaks, and at which slowly growing load
  /// breaks it [Pa].
  double strength(std::size_t tetrahedron) const { return strengths_[tetrahedron]; }
  std::span<const double> strengths() const { return strengths_; }

  /// From now on the tetrahedron gives way at this multiple of the strength that it had at first, and without
  /// delay: what the criterion waits for has happened.
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

  /// Goes on by one time step, in which the equivalent stress went from `before` to `after`. Called for the
  /// unbroken tetrahedra that are above the watched share of their strength at either end.
  /// @param earlier a step before `before`
  /// @return whether the tetrahedron breaks, or softens further, at the end of this step
  bool advance(std::size_t tetrahedron, double earlier, double before, double after) {
    // At the end of a step that is nearest to the moment.
    if (is_softened(tetrahedron)) return after + (after - before) / 2 > strengths_[tetrahedron];
    return integrate(tetrahedron, earlier, before, after);
  }

  /// The share of its strength above which a tetrahedron must be shown to advance() at the end of a step.
  /// @param stable_step in which a wave crosses the smallest tetrahedra [s]
  virtual double screening_share([[maybe_unused]] double stable_step) const { return 1; }

  /// Time to failure under constant stress from now on, without regard to the past [s]; infinity where it is
  /// over the strength by rounding only.
  double time_to_failure(std::size_t tetrahedron, double stress) const {
    if (!is_over(tetrahedron, stress)) return infinity;
    return is_softened(tetrahedron) ? 0 : delay(tetrahedron, stress);
  }

  /// What each tetrahedron remembers, 0 at first; empty for a criterion without memory. Checkpoints keep it.
  std::span<const double> memory() const { return memory_; }
  void set_memory(std::size_t tetrahedron, double value) { memory_[tetrahedron] = value; }

protected:
  /// advance() of one that is intact.
  virtual bool integrate(std::size_t tetrahedron, double earlier, double before, double after) = 0;
  /// time_to_failure() of an intact one that is over the strength.
  virtual double delay(std::size_t tetrahedron, double stress) const = 0;

  /// Whether a stress is above the strength by more than the rounding of a stress from displacements in 32
  /// bits.
  bool is_over(std::size_t tetrahedron, double stress) const {
    constexpr double rounding = 1e-5;
    return stress > strengths_[tetrahedron] * (1 + rounding);
  }

  std::unique_ptr<const EquivalentStress> stress_;
  std::vector<double> strengths_;
  std::vector<double> memory_;

private:
  std::vector<double> first_strengths_;    // empty while nothing has softened
  std::vector<std::uint8_t> is_softened_;  // likewise
};

/// The criterion that the input asks for.
/// @param strengths sigma_0 of each tetrahedron, or what follows from the input's toughness [Pa]
/// @param time_step that advance() will be called with [s]
std::unique_ptr<Criterion> make_criterion(const input::Parameters& parameters, std::vector<double> strengths,
                                          double time_step);

}  // namespace crackle::fracture
