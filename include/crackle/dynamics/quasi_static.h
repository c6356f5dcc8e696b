// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "crackle/common/real.h"
#include "crackle/dynamics/energy_account.h"
#include "crackle/fracture/breakable_body.h"
#include "crackle/fracture/criterion.h"
#include "crackle/fracture/stress_average.h"
#include "crackle/mechanics/boundary_loads.h"
#include "crackle/mechanics/static_solver.h"
#include "crackle/parallel/communicator.h"
#include "crackle/parallel/node_field.h"

#include <cstdint>
#include <functional>
#include <memory>
#include <span>
#include <vector>

namespace crackle::dynamics {

class CarriedShare;

/// How a quasi-static phase ended.
enum class QuasiStaticEnd {
  unstable,   ///< a tetrahedron is over the limit at an unchanged load: dynamics takes over
  no_load,    ///< no further load breaks the body
  separated,  ///< the loads are not held any more, or by what offers no stiffness: the body carries nothing
  parked,     ///< asked to stop between two breaks
};

/// Event-driven quasi-static loading. Between two breaks the equilibrium is linear in the loads: one unit
/// solution for each force pattern and each prescribed motion, scaled by its curve. Under a slow ramp the
/// Tuler-Butcher overshoot is negligible, so a tetrahedron breaks when its largest principal stress reaches
/// the strength.
class QuasiStaticLoading {
public:
  /// Solves for the intact body. Collective. The references must outlive the object.
  /// @param patience a tetrahedron over the limit that would take longer than this to break in dynamics [s]
  /// is
  ///        released quasi-statically: a dynamic phase would have ended as arrested before its first break
  /// @param average what the criterion sees instead of a tetrahedron's own stress, or nullptr
  /// @param ending_loads the loads, to end on fragments that come loose; nullptr: they go on
  QuasiStaticLoading(const parallel::Communicator& group, fracture::BreakableBody& body,
                     const mechanics::BoundaryLoads& loads, fracture::Criterion& criterion, double patience,
                     fracture::StressAverage* average = nullptr,
                     mechanics::BoundaryLoads* ending_loads = nullptr);
  ~QuasiStaticLoading();

  /// Puts the loads at time 0 into the account. Collective; once, before everything else.
  void load_at_start(EnergyAccount& account);

  /// @throws parallel::AgreedError on every rank when a tetrahedron is over its strength under the loads at
  /// time 0,
  ///   with the load at which the first one would have broken. Collective.
  void refuse_overload() const;

  /// The largest stress in the present equilibrium over its tetrahedron's strength; 0 where nothing is in
  /// tension. Collective.
  double stress_share() const;

  /// Loads on from the present time until instability or the end of the curve. Collective.
  /// @param is_asked_to_park this rank's request, polled after each break; may be empty
  /// @param on_equilibrium called on every rank with the loads before they rise and when they have risen, up
  ///   to a break or a kink of a program; may be empty
  QuasiStaticEnd advance(EnergyAccount& account, const std::function<bool()>& is_asked_to_park = {},
                         const std::function<void(const LoadState& loads)>& on_equilibrium = {});

  /// Continues at `time` from a body that came to rest after the dynamic state `displacement`, with what
  /// broke meanwhile: solves for its equilibrium and settles the account. Collective.
  /// @return false when the body carries nothing any more
  bool resume(double time, double kinetic, const parallel::NodeField& displacement, EnergyAccount& account);

  double time() const { return time_; }
  /// The machine's load at the last event [N].
  double load() const { return load_; }
  /// The same at the first break; NaN where nothing has broken quasi-statically.
  double load_at_first_break() const { return load_at_first_break_; }
  /// Largest residual of the solves so far, see mechanics::StaticSolver::residual.
  double residual() const { return residual_; }
  const parallel::NodeField& displacement() const { return displacement_; }
  std::int64_t n_solves() const { return n_solves_; }
  std::int64_t n_iterations() const { return n_iterations_; }
  std::int64_t n_breaks() const { return n_breaks_; }
  /// Equilibria at which something gave way: broke, or softened.
  std::int64_t n_events() const { return n_events_; }

private:
  struct Critical {
    double value = infinity;
    std::int64_t number = -1;  ///< in the realization; -1: none
    std::int32_t local = -1;   ///< on this rank, or -1
  };

  void solve_unit_problems(const mechanics::Accuracy& accuracy);
  /// Sum of the unit solutions times the factors of their programs.
  template <class ForceFactor, class MotionFactor>
  void superpose(std::span<double> sum, ForceFactor&& of_force, MotionFactor&& of_motion) const;
  void combine(double time, parallel::NodeField& displacement) const;
  /// Equilibrium anew. @return false when the body carries nothing any more
  /// @param may_separate whether tetrahedra or bridges broke, and did not only soften
  bool update_after_breaks(bool may_separate);
  /// By the unit solutions, in equilibrium or where the solver gave up. Collective.
  bool carries_nothing(bool is_equilibrium) const;
  /// True if a displacement is beyond what linear elasticity can describe. Collective.
  bool is_far(const parallel::NodeField& displacement) const;
  /// The largest stress over its tetrahedron's strength; of one round which it is averaged, the smaller of
  /// its own and the average.
  Critical most_loaded() const;
  /// The next to be loaded like that up to its strength.
  Critical first_to_break(double until) const;
  /// Local number of what breaks there now, or -1: the tetrahedron itself, or the one that its ball breaks.
  std::int32_t breaking(const Critical& critical) const;
  /// What gives way now: that of breaking(); where tetrahedra soften, all that are loaded nearly as much.
  std::vector<std::int32_t> all_breaking(const Critical& critical) const;
  /// Whether one over its strength would break before a dynamic phase counts as arrested.
  bool breaks_soon(std::int32_t tetrahedron, double load) const;
  /// Where a tetrahedron's load is looked at: itself, or the centre of the ball that stands for it. -1 where
  /// it is broken or another rank looks.
  std::int32_t place_of(std::int32_t tetrahedron) const;
  Critical agree(Critical local, bool smallest) const;

  const parallel::Communicator* group_;
  fracture::BreakableBody* body_;
  const mechanics::BoundaryLoads* loads_;
  mechanics::BoundaryLoads* ending_loads_;
  fracture::Criterion* criterion_;
  fracture::StressAverage* average_;
  double patience_;
  mechanics::StaticSolver solver_;
  std::vector<parallel::NodeField> unit_;  // for each force pattern, then for each motion that moves
  std::unique_ptr<const CarriedShare> carried_share_;
  parallel::NodeField displacement_;  // equilibrium at time_
  std::size_t n_changes_solved_ = 0;  // of the body's local changes, those that the solver knows
  double extent_ = 0;                 // of the body, the largest along an axis [m]
  double time_ = 0;
  double load_ = 0;  // [N]
  double load_at_first_break_ = not_a_number;
  double residual_ = 0;
  std::int64_t n_solves_ = 0;
  std::int64_t n_iterations_ = 0;
  std::int64_t n_breaks_ = 0;
  std::int64_t n_events_ = 0;
  int n_overloads_ = 0;  // looks in a row at which softening tetrahedra were over their strength
};

}  // namespace crackle::dynamics
