// SPDX-License-Identifier: GPL-3.0-or-later
// Loading in increments, where a term is not linear or cuts are closed: Newton's method and the path between
// two breaks.
#include "common/failure.h"
#include "common/index.h"
#include "dynamics/quasi_static.h"
#include "fracture/equivalent_stress.h"
#include "mechanics/internal_force.h"
#include "parallel/collectives.h"
#include "parallel/exact_sum.h"
#include "parallel/ghost_exchange.h"

#include <Eigen/Dense>

#include <algorithm>
#include <cmath>
#include <exception>
#include <utility>

namespace crackle::dynamics {

namespace {

/// Largest unbalanced force in equilibrium, relative to the forces.
constexpr double equilibrium_tolerance = 1e-8;
constexpr int max_newton_steps = 40;
/// It is not found either where the unbalanced force has not halved in so many steps.
constexpr int max_idle_steps = 20;
/// Nor where the body is so many of its extents away.
constexpr double farthest_iterate = 1e3;
/// The same where it hardly falls any more: by rounding, or as the terms' stiffness is not exact.
constexpr double slow_tolerance = 1e-4;
/// The same at the last step.
constexpr double last_tolerance = 1e-3;
/// A step of Newton's method is solved to the first of these accuracies, and later ones to a square of the
/// last decrease, within limits: more would be lost where contacts change.
constexpr double first_accuracy = 1e-3, coarsest_accuracy = 1e-2, finest_accuracy = 1e-10;
/// A step of Newton's method is cut where the unbalanced force does at most this share of the work on it that
/// it does at its start, or after so many trials.
constexpr double step_accuracy = 0.5;
constexpr int max_step_cuts = 10;
/// Steps that are a share of the one before, within these, and along it, with this square of the cosine.
constexpr double least_ratio = 0.02, largest_ratio = 0.95;
constexpr double aligned = 0.9;
/// An increment is straight if half-way along it the unbalanced force would do at most this share of the work
/// of the body's stiffness on it, or is at most that share of the forces, or after so many halvings. One
/// without an equilibrium at its end is halved so many times.
constexpr double straightness = 0.05;
constexpr double slight_imbalance = 5e-3;
constexpr int max_bends = 10;
constexpr int max_halvings = 30;
/// The largest share of the strength at a break is 1 within this, or after so many refinements.
constexpr double break_tolerance = 1e-8;
constexpr int max_refinements = 60;
/// An increment is at least this share of the one before.
constexpr double least_growth = 1e-3;

}  // namespace

QuasiStaticLoading::Imbalance QuasiStaticLoading::find_imbalance(double time, std::vector<double>& force) {
  const std::size_t n_owned = displacement_.owned().size();
  std::vector<double> loads(force.size()), of_strain(n_owned), of_terms(n_owned);
  for (const UnitLoad& load : unit_loads_) {
    const double factor = load.factor(time);
    if (!load.is_force() || factor == 0) continue;
    std::ranges::fill(force, 0.0);
    load.apply(force);
    for (std::size_t i = 0; i < n_owned; ++i) loads[i] += factor * force[i];
    if (load.kind == UnitLoad::Kind::strain)
      for (std::size_t i = 0; i < n_owned; ++i) of_strain[i] += factor * force[i];
  }
  springs_.clear();
  for (const NodeResponse& response : terms_.responses(time, displacement_.local())) {
    springs_.push_back(response);
    for (std::size_t i = 0; i < 3; ++i) of_terms[index(response.node, 0) + i] = response.force[i];
  }
  if (has_contact() && !body_->initial_strain().is_none()) {
    // Contact feels the elastic strain. The initial strain's share counts on the side of the loads.
    body_->force().evaluate(displacement_.local(), force);
    for (std::size_t i = 0; i < n_owned; ++i) force[i] += of_strain[i];
  } else {
    const mechanics::InternalForce of_displacement(body_->operators(), body_->residual_stiffness());
    of_displacement.evaluate(displacement_.local(), force);
  }
  const auto square = [&](std::span<const double> v) {
    return parallel::exact_dot(*group_, v.first(n_owned), v.first(n_owned));
  };
  const double forces = std::max({square(loads), square(of_terms), square(force)});
  for (std::size_t i = 0; i < n_owned; ++i) force[i] = held_[i] != 0 ? 0 : loads[i] + of_terms[i] - force[i];
  double unbalanced = square(force), largest = forces;
  if (!unknowns_.empty())
    for (const UnknownResponse& one : terms_.unknown_responses(time, displacement_.local())) {
      unbalanced += one.force * one.force;
      largest = std::max(largest, one.load * one.load);
    }
  return {std::sqrt(unbalanced), std::max(std::sqrt(largest), negligible_force_)};
}

void QuasiStaticLoading::find_step(double time, std::span<const double> force,
                                   const mechanics::Accuracy& accuracy, parallel::NodeField& change,
                                   std::vector<double>& of_unknowns) {
  // Block elimination: the response of the body to each unknown, then the unknowns, then the body.
  const auto n = static_cast<Eigen::Index>(unknowns_.size());
  const auto responses =
      n > 0 ? terms_.unknown_responses(time, displacement_.local()) : std::vector<UnknownResponse>();
  std::vector<parallel::NodeField> of_each;
  std::vector<std::vector<double>> couplings;
  for (const UnknownResponse& one : responses) {
    auto& coupling = couplings.emplace_back(displacement_.owned().size());
    for (const auto& [node, pull] : one.coupling)
      for (std::size_t i = 0; i < 3; ++i)
        if (held_[index(node, 0) + i] == 0) coupling[index(node, 0) + i] += pull[i];
    solve(coupling, of_each.emplace_back(*group_, body_->subdomain().layout), accuracy);
  }
  solve(force, change, accuracy);
  Eigen::MatrixXd matrix(n, n);
  Eigen::VectorXd balance(n);
  for (Eigen::Index a = 0; a < n; ++a) {
    const auto& coupling = couplings[index(a)];
    for (Eigen::Index b = 0; b < n; ++b)
      matrix(a, b) = (a == b ? responses[index(a)].stiffness : 0) -
                     parallel::exact_dot(*group_, coupling, std::as_const(of_each[index(b)]).owned());
    balance[a] =
        responses[index(a)].force + parallel::exact_dot(*group_, coupling, std::as_const(change).owned());
    // A tool that touches nothing comes closer, but not far.
    if (!(matrix(a, a) > 0))
      matrix(a, a) = std::max(std::abs(balance[a]), negligible_force_) / (1e-6 * extent_);
  }
  const Eigen::VectorXd unknown = matrix.ldlt().solve(balance);
  of_unknowns.assign(unknown.begin(), unknown.end());
  for (Eigen::Index a = 0; a < n; ++a)
    for (std::size_t i = 0; i < change.local().size(); ++i)
      change.local()[i] += unknown[a] * of_each[index(a)].local()[i];
}

void QuasiStaticLoading::find_equilibrium(double time) {
  std::vector<double> force(displacement_.local().size()), held(force.size());
  for (const UnitLoad& load : unit_loads_) {
    if (load.kind != UnitLoad::Kind::motion) continue;
    std::ranges::fill(force, 0.0);
    load.apply(force);
    for (std::size_t i = 0; i < force.size(); ++i) held[i] += load.factor(time) * force[i];
  }
  const auto u = displacement_.owned();
  for (std::size_t i = 0; i < u.size(); ++i)
    if (held_[i] != 0) u[i] = held[i];
  parallel::check_peers(*group_);
  displacement_.update_ghosts();
  take(displacement_.local(), time);
  double last = infinity, halved = infinity, forces = 0;
  int halved_at = 0;
  std::vector<double> before(u.size());
  for (int n = 0;; ++n) {
    const Imbalance now = find_imbalance(time, force);
    forces = std::max(forces, now.forces);  // where it ends without any, those on the way count
    const double residual = now.norm / forces;
    const bool is_slow = residual <= slow_tolerance && residual > 0.5 * last;
    if (residual < 0.5 * halved) {
      halved = residual;
      halved_at = n;
    }
    const bool is_last = n == max_newton_steps || n - halved_at == max_idle_steps;
    if (residual <= equilibrium_tolerance || is_slow || (is_last && residual <= last_tolerance)) {
      residual_ = std::max(residual_, residual);
      return;
    }
    // A mechanism moves without bound, until its forces leave the range of the solver's numbers.
    if (is_last || !std::isfinite(residual) || is_farther(displacement_, farthest_iterate))
      fail<mechanics::NoEquilibrium>(
          "no equilibrium at t = {:.6g} s: after {} steps of Newton's method the residual is still {:.1e} of "
          "the forces",
          time, n, residual);
    const double decrease = residual / last;
    const double enough = std::max(finest_accuracy, 0.1 * equilibrium_tolerance / residual);
    const mechanics::Accuracy accuracy{
        .of_loads =
            std::max(enough, n == 0 ? first_accuracy : std::min(decrease * decrease, coarsest_accuracy))};
    last = residual;
    parallel::NodeField change(*group_, body_->subdomain().layout);
    solver_.set_node_stiffness(springs_);
    if (has_contact()) solver_.release(contact_->linearize(displacement_.local()));
    std::exception_ptr no_equilibrium;
    std::vector<double> of_unknowns(unknowns_.size());
    try {
      find_step(time, std::span<const double>(force).first(u.size()), accuracy, change, of_unknowns);
    } catch (const mechanics::NoEquilibrium&) {
      no_equilibrium = std::current_exception();  // on every rank; how far the body moves may tell why
    }
    if (no_equilibrium) {
      for (std::size_t i = 0; i < displacement_.local().size(); ++i)
        displacement_.local()[i] += change.local()[i];
      std::rethrow_exception(no_equilibrium);
    }
    sum_up(change, before, of_unknowns);
    take_step(time, change, of_unknowns, force);
  }
}

void QuasiStaticLoading::sum_up(parallel::NodeField& change, std::vector<double>& before,
                                std::vector<double>& of_unknowns) const {
  const std::span<const double> now = std::as_const(change).owned();
  const double along = parallel::exact_dot(*group_, now, before);
  const double square = parallel::exact_dot(*group_, before, before);
  const double ratio = square > 0 ? along / square : 0;
  if (ratio >= least_ratio && ratio <= largest_ratio &&
      along * along >= aligned * square * parallel::exact_dot(*group_, now, now)) {
    for (double& value : change.local()) value /= 1 - ratio;
    for (double& value : of_unknowns) value /= 1 - ratio;
  }
  before.assign(now.begin(), now.end());
}

void QuasiStaticLoading::take_step(double time, const parallel::NodeField& change,
                                   const std::vector<double>& of_unknowns, std::vector<double>& force) {
  // The unbalanced force falls along the step, as its potential is convex: where its work on the step changes
  // sign, the potential is least.
  const std::vector<double> start = current();
  const std::size_t n_local = change.local().size();
  const auto go = [&](double share) {
    for (std::size_t i = 0; i < n_local; ++i) displacement_.local()[i] = start[i] + share * change.local()[i];
    for (std::size_t k = 0; k < unknowns_.size(); ++k)
      *unknowns_[k] = start[n_local + k] + share * of_unknowns[k];
  };
  const auto work_at = [&](double share) {
    go(share);
    find_imbalance(time, force);
    double work = parallel::exact_dot(*group_, std::span<const double>(force).first(change.owned().size()),
                                      change.owned());
    if (!unknowns_.empty()) {
      const auto responses = terms_.unknown_responses(time, displacement_.local());
      for (std::size_t k = 0; k < unknowns_.size(); ++k) work += responses[k].force * of_unknowns[k];
    }
    return work;
  };
  double low = 0, at_low = work_at(0), high = 1, at_high = work_at(1);
  const double least = -step_accuracy * at_low;
  double share = 1;
  for (int n = 0; at_low > 0 && at_high < least && n < max_step_cuts; ++n) {
    share = std::clamp(low + (high - low) * at_low / (at_low - at_high), std::lerp(low, high, 0.1),
                       std::lerp(low, high, 0.9));
    const double now = work_at(share);
    if (std::abs(now) <= -least) break;
    (now > 0 ? low : high) = share;
    (now > 0 ? at_low : at_high) = now;
  }
  go(share);
}

void QuasiStaticLoading::take(std::span<const double> displacement, double time) {
  const std::size_t n_local = displacement_.local().size();
  if (displacement.data() != displacement_.local().data())
    std::ranges::copy(displacement.first(n_local), displacement_.local().begin());
  for (std::size_t k = n_local; k < displacement.size(); ++k) *unknowns_[k - n_local] = displacement[k];
  time_ = time;
  body_->set_time(time);
  means_.clear();
}

QuasiStaticLoading::Critical QuasiStaticLoading::follow_path(double until) {
  std::vector<double> start = current(), end, between(start.size()), change(start.size());
  const double least = least_growth * break_tolerance * time_;
  double from = time_, to = std::min(until, from + std::max(increment_, least));
  group_->enter("static solve");
  for (int n = 0;; ++n) {
    bool is_straight = false;
    try {
      find_equilibrium(to);
      end = current();
      for (std::size_t i = 0; i < end.size(); ++i) between[i] = 0.5 * (start[i] + end[i]);
      take(between, 0.5 * (from + to));
      const Imbalance halfway = find_imbalance(time_, between);
      for (std::size_t i = 0; i < end.size(); ++i) change[i] = end[i] - start[i];
      const std::size_t n_owned = displacement_.owned().size();
      const double bend = parallel::exact_dot(*group_, std::span<const double>(between).first(n_owned),
                                              std::span<const double>(change).first(n_owned));
      const double work =
          2 * change_energy(*group_, *body_, {}, std::span(change).first(displacement_.local().size()));
      is_straight = n >= max_bends || halfway.norm <= slight_imbalance * halfway.forces ||
                    std::abs(bend) <= straightness * (work + negligible_work_);
    } catch (const mechanics::NoEquilibrium&) {  // on every rank
      if (n == max_halvings || !(0.5 * (from + to) > from)) throw;
      take(start, from);
    }
    increment_ = (n == 0 ? 2 : 1) * (to - from);
    if (is_straight) break;
    to = 0.5 * (from + to);
  }
  group_->enter("quasi-static loading");
  for (int n = 0;; ++n) {
    for (std::size_t i = 0; i < end.size(); ++i) between[i] = (end[i] - start[i]) / (to - from);
    take(start, from);
    Critical next = first_to_break(to, std::span(between).first(displacement_.local().size()));
    if (next.number < 0) {
      take(end, to);
      // At the end of a refined interval a tetrahedron may have reached its strength.
      const Critical most = most_loaded();
      return n > 0 && most.value >= 1 - break_tolerance ? most : next;
    }
    // Every third step halves the interval, so that it shrinks whatever the path.
    const double after = n % 3 == 2 ? 0.5 * (to - from) : next.value;
    for (std::size_t i = 0; i < end.size(); ++i) between[i] = start[i] + after * between[i];
    take(between, from + after);
    find_equilibrium(time_);
    const double share = most_loaded().value;
    if (std::abs(share - 1) <= break_tolerance || n == max_refinements) {
      increment_ = std::max({2 * (time_ - from), least_growth * increment_, least});
      return next;
    }
    (share < 1 ? start : end) = current();
    (share < 1 ? from : to) = time_;
    if (!(to > from)) return next;  // the path jumps: a tool's force has no equilibrium close by
  }
}

}  // namespace crackle::dynamics
