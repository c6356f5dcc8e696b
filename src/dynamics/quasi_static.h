// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "common/real.h"
#include "dynamics/contact_at_rest.h"
#include "dynamics/energy_account.h"
#include "dynamics/moving_body.h"
#include "dynamics/terms.h"
#include "fracture/breakable_body.h"
#include "fracture/fracture_law.h"
#include "mechanics/conditions.h"
#include "mechanics/static_solver.h"
#include "parallel/communicator.h"
#include "parallel/node_field.h"

#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <span>
#include <vector>

namespace crackle::dynamics {

class StiffnessRatio;

/// How a quasi-static phase ended.
enum class QuasiStaticEnd {
  unstable,   ///< a tetrahedron exceeds the limit at constant load: dynamics takes over
  no_load,    ///< no further loading breaks the body
  separated,  ///< the loads are no longer supported, or without stiffness: the body carries no load
  suspended,  ///< stopped on request between two breaks or increments
};

/// Event-driven quasi-static loading. Between breaks the equilibrium is linear in the loads: one unit
/// solution per unit load of the terms, scaled by its factor. If a term is not linear, the loads grow in
/// increments over which the body moves nearly straight, each to an equilibrium by Newton's method, and up to
/// the break on the way; so they do from where the first cut with contact closes. Under a slow ramp the
/// Tuler-Butcher overshoot is negligible, so a tetrahedron breaks when its largest principal stress reaches
/// the strength.
class QuasiStaticLoading {
public:
  /// Solves for the intact body. Collective. The context's members must outlive the object.
  /// @param patience a tetrahedron over the limit that would take longer than this to break in dynamics [s]
  ///   is released quasi-statically, as a dynamic phase would arrest before its first break
  /// @param ending_loads the loads, which end on fragments that come loose; nullptr: they continue
  QuasiStaticLoading(const MotionContext& context, double patience,
                     mechanics::Conditions* ending_loads = nullptr);
  /// Without any terms beside the conditions.
  QuasiStaticLoading(const parallel::Communicator& group, fracture::BreakableBody& body,
                     const mechanics::Conditions& loads, fracture::FractureLaw& law, double patience)
      : QuasiStaticLoading(MotionContext{&group, &body, &loads, &law}, patience) {}
  ~QuasiStaticLoading();

  /// Adds the loads and the initial strain at time 0 to the energy account. Collective; call once, first.
  void load_at_start(EnergyAccount& account);

  /// Collective. @throws parallel::AgreedError on every rank when a tetrahedron exceeds its strength under
  /// the loads at time 0, naming the load at which the first one would have broken
  void refuse_overload() const;

  /// The largest ratio of stress to strength in the current equilibrium; 0 if no tetrahedron is in tension.
  /// Collective.
  double stress_share() const;

  /// Share of the body's volume with a principal strain beyond a limit, in the current equilibrium.
  /// Collective.
  double strained_share(double limit) const;

  /// Continues loading until instability or the end of the curve. Collective.
  /// @param must_suspend this rank's request, polled after each break or increment; may be empty
  /// @param on_equilibrium called on every rank with the loads before and after each increment, up to a break
  ///   or a kink of a load curve; may be empty
  using OnEquilibrium = std::function<void(const LoadState& loads)>;
  QuasiStaticEnd advance(EnergyAccount& account, const std::function<bool()>& must_suspend = {},
                         const OnEquilibrium& on_equilibrium = {});

  /// Frees most of the solver's memory until resume(). Local.
  void rest() { solver_.rest(); }

  /// Continues at `time` from a body that came to rest after the dynamic state `displacement`, including its
  /// new breaks: solves for the equilibrium and updates the energy account. Collective.
  /// @return false when the body no longer carries any load
  bool resume(double time, double kinetic, const parallel::NodeField& displacement, EnergyAccount& account);

  /// The energy of the equilibrium, with what the terms store [J]. Collective.
  double strain_energy() const { return stored(displacement_); }

  double time() const { return time_; }
  /// True if a load, a motion or the initial strain changes from now on.
  bool grows() const;
  /// True once contact of cuts acts, see ContactAtRest.
  bool has_contact() const { return contact_ && contact_->acts(); }
  /// True if some are closed. Collective.
  bool cuts_are_closed() const { return has_contact() && contact_->closes(displacement_.local()); }
  /// The machine's load at the last event [N].
  double load() const { return load_; }
  /// The same at the first break; NaN if nothing has broken quasi-statically.
  double load_at_first_break() const { return load_at_first_break_; }
  /// Largest residual of the solves so far, see mechanics::StaticSolver::residual.
  double residual() const { return residual_; }
  const parallel::NodeField& displacement() const { return displacement_; }
  /// At an instability, by how much a stress exceeds the strength, relative to that, and how long the
  /// tetrahedron resists [s].
  double overload() const { return overload_; }
  double onset_delay() const { return onset_delay_; }
  std::int64_t n_solves() const { return n_solves_; }
  std::int64_t n_iterations() const { return n_iterations_; }
  std::int64_t n_breaks() const { return n_breaks_; }
  /// Number of equilibria at which something broke or softened.
  std::int64_t n_events() const { return n_events_; }

private:
  struct Critical {
    double value = infinity;
    std::int64_t number = -1;  ///< in the realization; -1: none
    std::int32_t local = -1;   ///< on this rank, or -1
  };

  /// Increases the loads, kink by kink of the load curves, until a tetrahedron reaches its limit. Collective.
  /// @param suspends asked after each increment, equal on every rank
  /// @param state receives the loads reached
  /// @param next receives the tetrahedron
  /// @return the end of the loading, if it comes first
  std::optional<QuasiStaticEnd> raise_loads(EnergyAccount& account, const std::function<bool()>& suspends,
                                            const OnEquilibrium& on_equilibrium, LoadState& state,
                                            Critical& next);
  /// Breaks or softens all that fails with a tetrahedron and solves for the next equilibrium. Collective.
  /// @param state receives the loads in it
  /// @return false when the body no longer carries any load
  bool break_and_relax(EnergyAccount& account, const Critical& next, LoadState& state);
  void solve_unit_problems(const mechanics::Accuracy& accuracy);
  /// Solves the problems that are not solved yet; of the parts of the initial strain those that act or change
  /// now: of a history that is a sum of many, few do.
  void solve_missing_problems(const mechanics::Accuracy& accuracy);
  void solve(std::span<const double> force, parallel::NodeField& displacement,
             const mechanics::Accuracy& accuracy);
  /// Superposition of the unit solutions, each times a factor of its load.
  template <class Factor>
  void superpose(std::span<double> sum, const Factor& factor) const;
  /// Newton's method for the equilibrium at a time, from the current displacement.
  /// @throws mechanics::NoEquilibrium on every rank
  void find_equilibrium(double time);
  /// Displacement, 3 n_local, and the terms' unknowns after it.
  std::vector<double> current() const;
  std::vector<double> unknowns() const;
  /// Evaluates with other values of the terms' unknowns.
  template <class Function>
  auto with_unknowns(const std::vector<double>& values, const Function& function);
  /// A step of Newton's method. @param force the imbalance @param change receives it, and that of unknowns
  void find_step(double time, std::span<const double> force, const mechanics::Accuracy& accuracy,
                 parallel::NodeField& change, std::vector<double>& of_unknowns);
  /// Sliding friction changes with the pressure, which the stiffness leaves out, so that each step is a share
  /// of the one before: takes the sum of the series. @param before the step before at owned nodes; receives
  /// this one
  void sum_up(parallel::NodeField& change, std::vector<double>& before,
              std::vector<double>& of_unknowns) const;
  /// Goes along it as far as the potential falls. @param force workspace
  void take_step(double time, const parallel::NodeField& change, const std::vector<double>& of_unknowns,
                 std::vector<double>& force);
  struct Imbalance {
    double norm = 0;    ///< of the unbalanced force
    double forces = 0;  ///< largest norm of the loads, the terms' forces and the body's, if not negligible
  };
  /// The unbalanced force at the current displacement and a time, and the terms' stiffness there.
  /// @param force receives it, 3 n_local; zero where the displacement is prescribed
  Imbalance find_imbalance(double time, std::vector<double>& force);
  /// Raises the loads by an increment along the path of equilibria, or up to a break on it.
  /// @return the tetrahedron that breaks, if any
  Critical follow_path(double until);
  /// Takes a displacement, as of current(), or without the unknowns, as that at a time.
  void take(std::span<const double> displacement, double time);
  void come_to_rest();
  /// Leaves the linear equilibria. Collective.
  void begin_increments();
  /// Finds the equilibrium at time_ with contact, which acts from now on. Collective.
  /// @param last displacement of the equilibrium before, 3 n_local
  void close_cuts(std::span<const double> last);
  /// True if a cut closes while the displacement changes at a rate, 3 n_local. Collective.
  bool closes_before(double until, std::span<const double> rate) const;
  /// Lost by terms and contact so far [J]. Collective.
  double lost() const;
  double stored(const parallel::NodeField& displacement) const;
  /// The loads at a displacement, with the works of all terms.
  LoadState measure(const parallel::NodeField& displacement, double time) const;
  /// The potential energy that the body loses, at constant loads, between a displacement and its equilibrium
  /// [J]. Collective.
  /// @param unknowns before
  double relaxation(const parallel::NodeField& before, const std::vector<double>& unknowns);
  /// Takes displacement and initial strain at time_.
  void combine();
  void end_loads(const mechanics::NodesOfConditions& nodes);
  /// Solves for the new equilibrium. @return false when the body no longer carries any load
  /// @param may_separate tetrahedra or bridges broke, rather than only softened
  bool update_after_breaks(bool may_separate);
  /// Decided from the unit solutions, converged or not. Collective.
  bool carries_nothing(bool is_equilibrium) const;
  /// True if a displacement exceeds so many extents of the body. Collective.
  bool is_farther(const parallel::NodeField& displacement, double extents) const;
  /// True if displacements beyond linear elasticity take hardly any energy. Collective.
  bool is_mechanism() const;
  /// The largest ratio of stress to strength; for averaged stress, the smaller of the tetrahedron's own ratio
  /// and its ball's; away from cracks, of its own and that of the largest mean around its corners.
  Critical most_loaded() const;
  /// The means around nodes in the current equilibrium; empty if none are needed.
  const std::vector<mechanics::Symmetric>& means() const;
  /// True if a tetrahedron must reach its strength in a mean, too.
  bool needs_mean(std::int32_t tetrahedron) const { return law_->needs_mean(tetrahedron); }
  /// Calls visit(patch) for the means around the corners of a tetrahedron that this rank knows. Some rank
  /// knows each, so that the largest of all ranks' largest means is the largest of all.
  template <class Visit>
  void for_means(std::int32_t tetrahedron, const Visit& visit) const {
    for (std::size_t corner = 0; corner < 4; ++corner)
      if (const auto patch = law_->means()->patch(tetrahedron, corner); patch >= 0) visit(index(patch));
  }
  /// The next tetrahedron to reach its strength while the displacement changes at a rate, 3 n_local.
  Critical first_to_break(double until, std::span<const double> rate) const;
  /// Local number of the tetrahedron that breaks there, or -1: the critical one itself, or the one selected
  /// by its ball.
  std::int32_t breaking(const Critical& critical) const;
  /// All tetrahedra that fail together: that of breaking() or, with softening, all whose load is nearly the
  /// largest.
  std::vector<std::int32_t> all_breaking(const Critical& critical) const;
  /// How long a tetrahedron resists this load, relative to its strength [s].
  /// @param tetrahedron local number; -1 on ranks that do not hold it
  double time_to_break(std::int32_t tetrahedron, double load) const;
  /// The tetrahedron at which another one's load is evaluated: itself, or the centre of the ball that
  /// represents it. -1 if it is broken or another rank is responsible.
  std::int32_t place_of(std::int32_t tetrahedron) const;
  Critical agree(Critical local, bool smallest) const;

  MotionContext context_;
  const parallel::Communicator* group_;
  fracture::BreakableBody* body_;
  const mechanics::Conditions* loads_;
  mechanics::Conditions* ending_loads_;
  fracture::FractureLaw* law_;
  double patience_;
  Terms terms_;
  bool is_linear_;
  std::vector<double*> unknowns_;  // of the terms
  std::vector<UnitLoad> unit_loads_;
  mechanics::HeldComponents held_;
  std::unique_ptr<ContactAtRest> contact_;  // nullptr: none
  mechanics::StaticSolver solver_;
  std::vector<mechanics::NodeStiffness> springs_;  // of the terms
  std::vector<parallel::NodeField> unit_;          // solution for each unit load
  std::vector<std::uint8_t> is_solved_;            // with the current stiffness
  std::unique_ptr<const StiffnessRatio> stiffness_ratio_;
  parallel::NodeField displacement_;                 // equilibrium at time_
  mutable std::vector<mechanics::Symmetric> means_;  // stresses around nodes there; empty: not computed yet
  std::size_t n_changes_solved_ = 0;  // number of the body's local changes included in the solver
  double extent_ = 0;                 // of the body, the largest along an axis [m]
  double negligible_force_ = 0;       // in increments [N]
  double negligible_work_ = 0;        // likewise, of an increment [J]
  double lost_ = 0;                   // so far, as the energy account has it [J]
  double time_ = 0;
  double increment_ = 1;     // of the load time, to be tried next in increments [s]
  double load_ = 0;          // [N]
  double largest_load_ = 0;  // so far [N]
  double load_at_first_break_ = not_a_number;
  double overload_ = 0, onset_delay_ = 0;
  double residual_ = 0;
  std::int64_t n_solves_ = 0;
  std::int64_t n_iterations_ = 0;
  std::int64_t n_breaks_ = 0;
  std::int64_t n_events_ = 0;
  int n_overloads_ = 0;  // consecutive checks at which softening tetrahedra exceeded their strength
};

}  // namespace crackle::dynamics
