// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "common/real.h"
#include "fracture/equivalent_stress.h"

#include <algorithm>
#include <cstdint>

namespace crackle::fracture {

/// Smallest s in (0, limit] at which the equivalent stress of stress + s rate reaches `strength`, to the last
/// bit; infinity if there is none. `limit` may be infinite.
/// @pre the value is below the strength at s = 0
double crossing(const EquivalentStress& value, const mechanics::Symmetric& stress,
                const mechanics::Symmetric& rate, double strength, double limit);

/// Finds which of many tetrahedra first reaches its strength while the stress grows linearly.
///
/// The result is bitwise independent of the order of the tetrahedra and of their distribution over ranks:
/// each crossing is computed from its own data and `limit` alone. Earlier tetrahedra only rule out later
/// ones, with a tolerance for the rounding of the stresses.
class FirstCrossing {
public:
  /// @param value must outlive the object
  FirstCrossing(const EquivalentStress& value, double limit) : of_(&value), limit_(limit) {}

  void see(const mechanics::Symmetric& stress, const mechanics::Symmetric& rate, double strength,
           std::int64_t number);

  /// For a tetrahedron that must reach its strength both by itself and in an average. At the start, one of
  /// the two values may exceed the strength, but not both.
  /// @param average gives the crossing_from() of the average, or infinity if that is certainly later than the
  /// first
  ///   one so far; called only if it may matter
  template <class Average>
  void see(const mechanics::Symmetric& stress, const mechanics::Symmetric& rate, double strength,
           std::int64_t number, const Average& average) {
    if (comes_later(stress, rate, strength)) return;
    if (const double mean = average(); mean <= value_)
      take(std::max(crossing_from(stress, rate, strength), mean), number);
  }

  /// The crossing_from(), or infinity if it is certainly later than the first one so far.
  double crossing_unless_later(const mechanics::Symmetric& stress, const mechanics::Symmetric& rate,
                               double strength) const {
    return comes_later(stress, rate, strength) ? infinity : crossing_from(stress, rate, strength);
  }

  /// The crossing() within the limit; 0 if the strength is reached at the start.
  double crossing_from(const mechanics::Symmetric& stress, const mechanics::Symmetric& rate,
                       double strength) const;

  double value() const { return value_; }          ///< infinity: no crossing within the limit
  std::int64_t number() const { return number_; }  ///< the smallest number among the first; -1: none

private:
  /// True if certainly later than the first one so far.
  bool comes_later(const mechanics::Symmetric& stress, const mechanics::Symmetric& rate,
                   double strength) const;
  void take(double s, std::int64_t number);

  const EquivalentStress* of_;
  double limit_;
  double value_ = infinity;
  std::int64_t number_ = -1;
};

}  // namespace crackle::fracture
