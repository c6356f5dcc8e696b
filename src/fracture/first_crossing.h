// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "crackle/common/real.h"
#include "crackle/fracture/equivalent_stress.h"

#include <algorithm>
#include <cstdint>

namespace crackle::fracture {

/// Smallest s in (0, limit] at which the equivalent stress of stress + s rate reaches `strength`, to the last
/// bit; infinity where there is none. `limit` may be infinite.
/// @pre the value is below the strength at s = 0
double crossing(const EquivalentStress& value, const mechanics::Symmetric& stress,
                const mechanics::Symmetric& rate, double strength, double limit);

/// Which of many tetrahedra reaches its strength first while the stress grows linearly.
///
/// What comes out has the same bits whatever the order in which the tetrahedra are shown, and whoever else
/// looks at some of them: each crossing is found from its own numbers and `limit` alone. Earlier tetrahedra
/// only tell which of the later ones need no search, with room for the rounding of the stresses.
class FirstCrossing {
public:
  /// @param value must outlive the object
  FirstCrossing(const EquivalentStress& value, double limit) : of_(&value), limit_(limit) {}

  void see(const mechanics::Symmetric& stress, const mechanics::Symmetric& rate, double strength,
           std::int64_t number);

  /// One that must reach its strength itself, and in an average. The values may be above the strength at the
  /// start, but not both of them.
  /// @param average gives the average of stress over strength and its rate; called where it may matter only
  template <class Average>
  void see(const mechanics::Symmetric& stress, const mechanics::Symmetric& rate, double strength,
           std::int64_t number, const Average& average) {
    if (comes_later(stress, rate, strength)) return;
    const auto [mean, mean_rate] = average();
    take(std::max(crossing_from(stress, rate, strength), crossing_from(mean, mean_rate, 1)), number);
  }

  double value() const { return value_; }          ///< infinity: none within the limit
  std::int64_t number() const { return number_; }  ///< the smallest of those that come first; -1: none

private:
  /// Surely after the first one so far.
  bool comes_later(const mechanics::Symmetric& stress, const mechanics::Symmetric& rate,
                   double strength) const;
  /// 0 where the strength is reached at the start.
  double crossing_from(const mechanics::Symmetric& stress, const mechanics::Symmetric& rate,
                       double strength) const;
  void take(double s, std::int64_t number);

  const EquivalentStress* of_;
  double limit_;
  double value_ = infinity;
  std::int64_t number_ = -1;
};

}  // namespace crackle::fracture
