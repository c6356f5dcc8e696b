// SPDX-License-Identifier: GPL-3.0-or-later
#include "dynamics/quasi_static.h"

#include "common/failure.h"
#include "common/index.h"
#include "common/vector.h"
#include "dynamics/machine_load.h"
#include "dynamics/separation.h"
#include "fracture/connectivity.h"
#include "fracture/equivalent_stress.h"
#include "fracture/first_crossing.h"
#include "mechanics/node_cells.h"
#include "parallel/agreement.h"
#include "parallel/collectives.h"
#include "parallel/exact_sum.h"
#include "parallel/ghost_exchange.h"

#include "loose_loads.h"
#include "stiffness_ratio.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <exception>
#include <iterator>
#include <unordered_map>
#include <utility>

namespace crackle::dynamics {

namespace {

/// Displacements above this share of the body's extent indicate a mechanism, far beyond linear elasticity.
constexpr double mechanism_displacement = 0.2;
/// A body with such displacements and less than this share of its intact stiffness is a mechanism.
constexpr double weak_share = 1e-3;

/// Softening tetrahedra whose load is at least this share of their strength soften at the same time, some ten
/// in one equilibrium. Those that follow at constant load exceed their strength, so the two errors in the
/// dissipated energy have opposite signs.
constexpr double simultaneous_share = 0.97;
/// Softening counts as unstable after this many equilibria at constant load, or above this load relative to
/// the threshold.
constexpr int max_overloads = 20;
constexpr double slight_overload = 1.2;

/// Accuracy of the equilibria between softening events. The largest load is then accurate to some 2e-3, less
/// than the spread of loads that soften at the same time, in a twentieth of the iterations.
constexpr mechanics::Accuracy softening_accuracy{.of_loads = 1e-4, .of_displacement = 5e-3};

// Where a term is not linear.
/// Forces that strain the body less than this count as none, and so does this share of the energy at which
/// it has its strength everywhere.
constexpr double negligible_strain = 1e-9;
constexpr double negligible_energy_share = 1e-7;
/// A tool that has gone further than this many extents of the body has left it, or has passed through it.
constexpr double tool_way = 2;
/// A body that has broken and carries less than this share of the largest load counts as separated.
constexpr double least_load_share = 0.01;

}  // namespace

QuasiStaticLoading::QuasiStaticLoading(const MotionContext& context, double patience,
                                       mechanics::Conditions* ending_loads)
    : context_(context),
      group_(context.group),
      body_(context.body),
      loads_(context.loads),
      ending_loads_(ending_loads),
      law_(context.law),
      patience_(patience),
      terms_(context_),
      is_linear_(std::ranges::all_of(terms_, [](const auto& term) { return term->is_linear(); })),
      unknowns_(terms_.unknowns()),
      unit_loads_(terms_.unit_loads()),
      held_(terms_.held_components(body_->subdomain())),
      contact_(body_->has_contact() ? std::make_unique<ContactAtRest>(*group_, *body_) : nullptr),
      solver_(*group_, body_->subdomain(), body_->operators(), body_->elasticity(), body_->edges(),
              contact_ ? contact_->tangent() : body_->residual_stiffness(), held_),
      displacement_(*group_, body_->subdomain().layout) {
  const geometry::Box box = mechanics::box_of_all(*group_, body_->subdomain());
  extent_ = std::ranges::max(box.upper - box.lower);
  const std::vector<double> none(displacement_.local().size());
  if (!is_linear_) {
    begin_increments();
    if (contact_) contact_->start(none);
    group_->enter("static solve");
    find_equilibrium(time_);
    come_to_rest();
    group_->enter("quasi-static loading");
    return;
  }
  for (const UnitLoad& load : unit_loads_) {
    auto& unit = unit_.emplace_back(*group_, body_->subdomain().layout);
    if (load.kind == UnitLoad::Kind::motion) load.apply(unit.local());
  }
  for (const NodeResponse& response : terms_.responses(time_, displacement_.local()))
    springs_.push_back(response);
  solver_.set_node_stiffness(springs_);
  group_->enter("static solve");
  try {
    solve_unit_problems({});
  } catch (const mechanics::NoEquilibrium&) {
    if (!contact_) throw;
    close_cuts(none);  // on every rank
    group_->enter("quasi-static loading");
    return;
  }
  group_->enter("quasi-static loading");
  stiffness_ratio_ = std::make_unique<const StiffnessRatio>(*group_, *body_, unit_loads_, springs_, unit_);
  combine();
  if (contact_ && contact_->closes(displacement_.local())) close_cuts(none);
}

void QuasiStaticLoading::begin_increments() {
  is_linear_ = false;
  unit_.clear();
  negligible_force_ = negligible_strain * extent_ * bar_stiffness(*group_, *body_);
  negligible_work_ = negligible_energy_share * energy_at_strength(*group_, *body_, law_->strengths());
}

void QuasiStaticLoading::close_cuts(std::span<const double> last) {
  contact_->start(last);
  begin_increments();
  take(last, time_);
  group_->enter("static solve");
  find_equilibrium(time_);
  group_->enter("quasi-static loading");
  come_to_rest();
}

bool QuasiStaticLoading::closes_before(double until, std::span<const double> rate) const {
  const auto strain_rate = [&](std::int32_t t) { return body_->strain_rate(t, rate); };
  if (std::isinf(until)) return contact_->closes_in_the_end(strain_rate);
  return contact_->closes([&](std::int32_t t) {
    mechanics::Symmetric strain = body_->strain(t, displacement_.local());
    const mechanics::Symmetric change = strain_rate(t);
    for (std::size_t i = 0; i < strain.size(); ++i) strain[i] += (until - time_) * change[i];
    return strain;
  });
}

double QuasiStaticLoading::lost() const {
  return terms_.dissipated() + (contact_ ? contact_->dissipated() : 0);
}

QuasiStaticLoading::~QuasiStaticLoading() = default;

void QuasiStaticLoading::solve_unit_problems(const mechanics::Accuracy& accuracy) {
  is_solved_.assign(unit_loads_.size(), 0);
  solve_missing_problems(accuracy);
}

void QuasiStaticLoading::solve_missing_problems(const mechanics::Accuracy& accuracy) {
  std::vector<double> force(displacement_.local().size());
  for (std::size_t k = 0; k < unit_loads_.size(); ++k) {
    const UnitLoad& load = unit_loads_[k];
    const bool acts = load.kind != UnitLoad::Kind::strain || load.factor(time_) != 0 || load.rate(time_) != 0;
    if (!acts || std::exchange(is_solved_[k], std::uint8_t{1}) != 0) continue;
    std::ranges::fill(force, 0.0);
    if (load.is_force()) load.apply(force);
    solve(std::span<const double>(force).first(displacement_.owned().size()), unit_[k], accuracy);
  }
}

void QuasiStaticLoading::solve(std::span<const double> force, parallel::NodeField& displacement,
                               const mechanics::Accuracy& accuracy) {
  n_iterations_ += solver_.solve(force, displacement, accuracy);
  if (is_linear_) residual_ = std::max(residual_, solver_.residual());
  ++n_solves_;
}

template <class Factor>
void QuasiStaticLoading::superpose(std::span<double> sum, const Factor& factor) const {
  std::ranges::fill(sum, 0.0);
  for (std::size_t k = 0; k < unit_loads_.size(); ++k) {
    const double times = factor(unit_loads_[k]);
    // The parts of the initial strain that do not act now need not be solved for.
    if (unit_loads_[k].kind == UnitLoad::Kind::strain && times == 0) continue;
    const auto u = unit_[k].local();
    for (std::size_t i = 0; i < sum.size(); ++i) sum[i] += times * u[i];
  }
}

LoadState QuasiStaticLoading::measure(const parallel::NodeField& displacement, double time) const {
  LoadState state = terms_.measure(time, displacement, nullptr);
  state.stored = is_linear_ ? dynamics::strain_energy(state) : stored(displacement);
  return state;
}

void QuasiStaticLoading::come_to_rest() {
  for (const auto& term : terms_) term->rest_at(time_, displacement_);
  if (has_contact()) contact_->settle(displacement_.local());
}

double QuasiStaticLoading::stored(const parallel::NodeField& displacement) const {
  return dynamics::strain_energy(*group_, *body_, displacement.local()) + terms_.stored(displacement);
}

std::vector<double> QuasiStaticLoading::unknowns() const {
  std::vector<double> values;
  for (const double* one : unknowns_) values.push_back(*one);
  return values;
}

std::vector<double> QuasiStaticLoading::current() const {
  const auto u = displacement_.local();
  std::vector<double> state(u.begin(), u.end());
  std::ranges::copy(unknowns(), std::back_inserter(state));
  return state;
}

template <class Function>
auto QuasiStaticLoading::with_unknowns(const std::vector<double>& values, const Function& function) {
  const auto exchange = [&](const std::vector<double>& other) {
    for (std::size_t k = 0; k < unknowns_.size(); ++k) *unknowns_[k] = other[k];
  };
  const std::vector<double> now = unknowns();
  exchange(values);
  auto result = function();
  exchange(now);
  return result;
}

void QuasiStaticLoading::combine() {
  superpose(displacement_.local(), [this](const UnitLoad& load) { return load.factor(time_); });
  body_->set_time(time_);
  means_.clear();
}

bool QuasiStaticLoading::grows() const {
  return std::ranges::any_of(unit_loads_, [this](const UnitLoad& load) { return load.grows_after(time_); });
}

void QuasiStaticLoading::end_loads(const mechanics::NodesOfConditions& nodes) {
  terms_.end_loads(time_, nodes, displacement_);
  ending_loads_->end_loads(*group_, nodes);
}

bool QuasiStaticLoading::update_after_breaks(bool may_separate) {
  parallel::check_peers(*group_);
  law_->follow_cracks(*group_);
  const auto changes = body_->changes().subspan(n_changes_solved_);
  if (contact_) contact_->take_over(changes);
  solver_.release(changes);
  n_changes_solved_ += changes.size();
  if (may_separate) {
    const auto labels = fracture::piece_labels(*group_, *body_);
    if (ending_loads_ != nullptr) {
      if (const auto nodes = nodes_of_loose_pieces(*group_, *body_, *loads_, labels)) end_loads(*nodes);
      if (const auto nodes = nodes_of_falling_splinters(*group_, *body_, *loads_)) end_loads(*nodes);
    }
    if (!loads_are_supported(*group_, *body_, *loads_, labels)) return false;
  }
  const std::vector<double> last = current();
  const double residual = residual_;
  group_->enter("static solve");
  std::exception_ptr no_equilibrium;
  try {
    if (is_linear_)
      solve_unit_problems(body_->softens() ? softening_accuracy : mechanics::Accuracy{});
    else
      find_equilibrium(time_);
  } catch (const mechanics::NoEquilibrium&) {
    no_equilibrium = std::current_exception();  // on every rank
  }
  if (is_linear_) {
    combine();
    if (contact_ && contact_->closes(displacement_.local())) {
      no_equilibrium = nullptr;
      try {
        close_cuts(last);
      } catch (const mechanics::NoEquilibrium&) {
        no_equilibrium = std::current_exception();  // likewise
      }
    }
  }
  group_->enter("quasi-static loading");
  // Under a force on a tool a body that no longer carries it gives way.
  const bool gives_way = no_equilibrium && !unknowns_.empty();
  if (gives_way || carries_nothing(!no_equilibrium)) {
    take(last, time_);
    residual_ = residual;  // of a solution that is discarded
    return false;
  }
  if (no_equilibrium) std::rethrow_exception(no_equilibrium);
  return true;
}

bool QuasiStaticLoading::carries_nothing(bool is_equilibrium) const {
  // A part that hangs by a corner or an edge is a mechanism: forces move it without bound, and prescribed
  // motions meet no resistance.
  const bool is_known = std::ranges::none_of(displacement_.owned(), [](double u) { return std::isnan(u); });
  parallel::check_peers(*group_);
  if (parallel::any_of_all(*group_, !is_known)) return false;
  // Without unit solutions the displacement tells.
  const double share = is_linear_ ? stiffness_ratio_->at(time_, unit_) : 0.5 * weak_share;
  if (share < least_share || (share < weak_share && is_mechanism())) return true;
  // Conjugate gradients come from below: what they have not found is even farther away.
  if (!is_equilibrium && is_linear_ && is_farther(displacement_, 1)) return true;
  // Without an equilibrium, hinges keep the body together but allow it to move.
  return !is_equilibrium && !loads_are_supported_by_faces(*group_, *body_, *loads_);
}

bool QuasiStaticLoading::is_farther(const parallel::NodeField& displacement, double extents) const {
  double largest = 0;
  for (const double u : displacement.owned()) largest = std::max(largest, std::abs(u));
  parallel::check_peers(*group_);
  return parallel::largest_of_all(*group_, largest) > extents * extent_;
}

bool QuasiStaticLoading::is_mechanism() const {
  if (!is_farther(displacement_, mechanism_displacement)) return false;
  if (is_linear_) return stiffness_ratio_->at(time_, unit_) < weak_share;
  if (!cuts_are_closed()) return true;
  const double way = mechanism_displacement * extent_;
  return stored(displacement_) < 0.5 * weak_share * bar_stiffness(*group_, *body_) * way * way;
}

QuasiStaticLoading::Critical QuasiStaticLoading::agree(Critical local, bool smallest) const {
  parallel::check_peers(*group_);
  if (!smallest) local.value = -local.value;
  const double best = parallel::all_reduce(*group_, local.number < 0 ? infinity : local.value, MPI_MIN);
  Critical agreed;
  agreed.value = smallest ? best : -best;
  constexpr auto none = std::numeric_limits<std::int64_t>::max();
  const std::int64_t number =
      parallel::all_reduce(*group_, local.number >= 0 && local.value == best ? local.number : none, MPI_MIN);
  if (number == none) return agreed;
  agreed.number = number;
  agreed.local = body_->subdomain().local_number(number);
  return agreed;
}

std::int32_t QuasiStaticLoading::place_of(std::int32_t tetrahedron) const {
  if (body_->is_broken(tetrahedron)) return -1;
  if (law_->average() == nullptr) return tetrahedron;
  const std::int32_t centre = law_->average()->centre(tetrahedron);
  return body_->subdomain().owned[index(centre)] != 0 ? centre : -1;
}

const std::vector<mechanics::Symmetric>& QuasiStaticLoading::means() const {
  if (means_.empty() && law_->means() != nullptr)
    means_ = law_->means()->all([&](std::int32_t t) { return body_->stress(t, displacement_.local()); });
  return means_;
}

QuasiStaticLoading::Critical QuasiStaticLoading::most_loaded() const {
  Critical best;
  best.value = -infinity;
  const auto u = displacement_.local();
  const auto& means = this->means();
  const auto stress = [&](std::int32_t t) { return body_->stress(t, u); };
  std::unordered_map<std::int32_t, double> averaged;  // loads of balls
  for (std::int32_t t = 0; t < body_->subdomain().n_tetrahedra(); ++t) {
    const std::int32_t place = place_of(t);
    if (place < 0) continue;
    const mechanics::Symmetric sigma = stress(t);
    const double strength = law_->strength(static_cast<std::size_t>(t));
    // The tolerance for rounding makes the choice between nearly equal loads independent of what this rank
    // evaluated before.
    if (best.number >= 0 && law_->stress().bound(sigma) < best.value * strength -
                                                              1e-12 * std::abs(best.value * strength) -
                                                              fracture::EquivalentStress::rounding(sigma))
      continue;
    double load = law_->stress()(sigma) / strength;
    if (law_->average() != nullptr && load > best.value) {
      const auto [ball, is_new] = averaged.try_emplace(place);
      if (is_new) ball->second = law_->stress()((*law_->average())(place, stress));
      load = std::min(load, ball->second);
    }
    if (load > best.value && needs_mean(t)) {
      double largest = -infinity;
      for_means(t, [&](std::size_t patch) { largest = law_->stress().larger(largest, means[patch]); });
      load = std::min(load, largest / strength);
    }
    if (best.number < 0 || load > best.value) {
      best.value = load;
      best.number = body_->subdomain().tetrahedron_number[index(place)];
    }
  }
  return agree(best, false);
}

QuasiStaticLoading::Critical QuasiStaticLoading::first_to_break(double until,
                                                                std::span<const double> rate) const {
  fracture::FirstCrossing first(law_->stress(), until - time_);
  const auto u = displacement_.local();
  const auto stress = [&](std::int32_t t) { return body_->stress(t, u); };
  const auto stress_rate = [&](std::int32_t t) { return body_->stress_rate(t, rate); };
  std::unordered_map<std::int32_t, double> averaged;  // crossings of balls
  const auto& means = this->means();
  const auto mean_rates = means.empty() ? means : law_->means()->all(stress_rate);
  for (std::int32_t t = 0; t < body_->subdomain().n_tetrahedra(); ++t) {
    const std::int32_t place = place_of(t);
    if (place < 0) continue;
    const double strength = law_->strength(static_cast<std::size_t>(t));
    const std::int64_t number = body_->subdomain().tetrahedron_number[index(place)];
    if (law_->average() != nullptr)
      first.see(stress(t), stress_rate(t), strength, number, [&] {
        const auto [ball, is_new] = averaged.try_emplace(place);
        if (is_new)
          ball->second = first.crossing_from((*law_->average())(place, stress),
                                             (*law_->average())(place, stress_rate), 1);
        return ball->second;
      });
    else if (needs_mean(t))
      first.see(stress(t), stress_rate(t), strength, number, [&] {
        double earliest = infinity;
        for_means(t, [&](std::size_t patch) {
          earliest =
              std::min(earliest, first.crossing_unless_later(means[patch], mean_rates[patch], strength));
        });
        return earliest;
      });
    else
      first.see(stress(t), stress_rate(t), strength, number);
  }
  return agree({first.value(), first.number()}, true);
}

std::int32_t QuasiStaticLoading::breaking(const Critical& critical) const {
  if (law_->average() == nullptr) return critical.local;
  const auto& subdomain = body_->subdomain();
  std::int64_t number = -1;
  if (critical.local >= 0 && place_of(critical.local) == critical.local)
    number = subdomain.tetrahedron_number[index(law_->average()->most_stressed(
        critical.local, law_->stress(),
        [&](std::int32_t t) { return body_->stress(t, displacement_.local()); }))];
  parallel::check_peers(*group_);
  return subdomain.local_number(parallel::all_reduce(*group_, number, MPI_MAX));
}

std::vector<std::int32_t> QuasiStaticLoading::all_breaking(const Critical& critical) const {
  std::vector<std::int32_t> all;
  if (!body_->softens()) {
    if (const auto t = breaking(critical); t >= 0) all.push_back(t);
    return all;
  }
  // All ranks that hold a tetrahedron reach the same decision.
  const auto u = displacement_.local();
  for (std::int32_t t = 0; t < body_->subdomain().n_tetrahedra(); ++t)
    if (!body_->is_broken(t) &&
        law_->stress().exceeds(body_->stress(t, u), simultaneous_share * law_->strength(index(t))))
      all.push_back(t);
  return all;
}

double QuasiStaticLoading::time_to_break(std::int32_t tetrahedron, double load) const {
  double time = infinity;
  if (tetrahedron >= 0) {
    const auto t = static_cast<std::size_t>(tetrahedron);
    time = law_->time_to_failure(t, load * law_->strength(t));
  }
  parallel::check_peers(*group_);
  return parallel::all_reduce(*group_, time, MPI_MIN);
}

double QuasiStaticLoading::relaxation(const parallel::NodeField& before,
                                      const std::vector<double>& unknowns) {
  if (!is_linear_) {
    const double stored_before = with_unknowns(unknowns, [&] { return stored(before); });
    const LoadState loads_before = with_unknowns(unknowns, [&] { return measure(before, time_); });
    return stored_before - stored(displacement_) + static_work(loads_before, measure(displacement_, time_));
  }
  std::vector<double> difference(before.local().size());
  for (std::size_t i = 0; i < difference.size(); ++i)
    difference[i] = before.local()[i] - displacement_.local()[i];
  return change_energy(*group_, *body_, springs_, difference);
}

double QuasiStaticLoading::stress_share() const {
  const Critical most = most_loaded();
  return most.number < 0 ? 0 : std::max(0.0, most.value);
}

double QuasiStaticLoading::strained_share(double limit) const {
  std::array<double, 2> volume{};  // of the strained part, of all
  for (std::int32_t t = 0; t < body_->subdomain().n_tetrahedra(); ++t) {
    if (body_->subdomain().owned[index(t)] == 0) continue;
    const double own = body_->operators().tetrahedra[index(t)].volume;
    volume[1] += own;
    mechanics::Symmetric strain = body_->strain(t, displacement_.local());
    const double stretch = fracture::largest_principal(strain);
    for (double& component : strain) component = -component;
    if (std::max(stretch, fracture::largest_principal(strain)) > limit) volume[0] += own;
  }
  parallel::check_peers(*group_);
  parallel::all_reduce(*group_, volume, MPI_SUM);
  return volume[0] / volume[1];
}

void QuasiStaticLoading::load_at_start(EnergyAccount& account) {
  // The initial loads, and the initial strain, are taken to have grown from zero.
  const LoadState state = measure(displacement_, time_);
  lost_ = lost();
  if (is_linear_)
    account.add_static_work({.works = std::vector<Work>(state.works.size())}, state);
  else
    account.add_phase(state.stored + lost_, lost_);
  load_ = machine_load(*loads_, state).force;
}

void QuasiStaticLoading::refuse_overload() const {
  const Critical most = most_loaded();
  if (most.number < 0 || most.value <= 1) return;
  if (std::ranges::count(unit_loads_, UnitLoad::Kind::strain, &UnitLoad::kind) > 0)
    throw parallel::AgreedError(
        0, fmt::format("at time 0 the initial stress, with the loads then, is {:.4g} times the strength of a "
                       "tetrahedron; lower it, or set time.start = \"equilibrium\" to start the dynamic "
                       "phase at time 0",
                       most.value));
  // The largest load of any condition; the machine's may be smaller.
  const double load = largest_load(*loads_, measure(displacement_, time_));
  throw parallel::AgreedError(
      0,
      fmt::format("the load at time 0, {:.6g} N, exceeds that of the first break, {:.6g} N; lower the loads "
                  "at time 0, or set time.start = \"equilibrium\" to start the dynamic phase at time 0",
                  load, load / most.value));
}

QuasiStaticEnd QuasiStaticLoading::advance(EnergyAccount& account, const std::function<bool()>& must_suspend,
                                           const OnEquilibrium& on_equilibrium) {
  const auto suspends = [&] {
    if (!must_suspend) return false;
    const bool is_requested = must_suspend();
    parallel::check_peers(*group_);
    return parallel::any_of_all(*group_, is_requested);
  };
  LoadState state = measure(displacement_, time_);
  for (;;) {
    if (suspends()) return QuasiStaticEnd::suspended;
    Critical next = most_loaded();
    if (next.number < 0) return QuasiStaticEnd::separated;
    load_ = machine_load(*loads_, state).force;
    if (next.value <= 1) n_overloads_ = 0;
    const bool may_settle = body_->softens() && next.value <= slight_overload && n_overloads_ < max_overloads;
    if (next.value > 1 && !may_settle) {
      // It is unstable if it breaks before a dynamic phase counts as arrested.
      overload_ = next.value - 1;
      onset_delay_ = time_to_break(breaking(next), next.value);
      if (onset_delay_ <= patience_) {
        n_overloads_ = 0;
        return QuasiStaticEnd::unstable;
      }
    }
    if (next.value > 1) ++n_overloads_;
    if (next.value < 1)
      if (const auto end = raise_loads(account, suspends, on_equilibrium, state, next)) return *end;
    load_ = machine_load(*loads_, state).force;
    if (!break_and_relax(account, next, state)) return QuasiStaticEnd::separated;
    // Without unit solutions the load tells that hardly anything carries it.
    largest_load_ = std::max(largest_load_, load_);
    if (!is_linear_ && std::abs(machine_load(*loads_, state).force) < least_load_share * largest_load_)
      return QuasiStaticEnd::separated;
  }
}

std::optional<QuasiStaticEnd> QuasiStaticLoading::raise_loads(EnergyAccount& account,
                                                              const std::function<bool()>& suspends,
                                                              const OnEquilibrium& on_equilibrium,
                                                              LoadState& state, Critical& next) {
  if (on_equilibrium) on_equilibrium(state);
  std::vector<double> rate(displacement_.local().size()), last;
  for (;;) {
    double kink = infinity;
    for (const UnitLoad& load : unit_loads_) kink = std::min(kink, load.curve->next_kink(time_));
    const double last_time = time_;
    last = current();
    if (is_linear_) {
      superpose(rate, [this](const UnitLoad& load) { return load.rate(time_); });
      next = first_to_break(kink, rate);
      if (contact_ && closes_before(next.number < 0 ? kink : time_ + next.value, rate)) {
        if (next.number >= 0) increment_ = next.value;
        close_cuts(last);
        continue;
      }
      if (next.number < 0 && (std::isinf(kink) || !grows())) return QuasiStaticEnd::no_load;
      time_ = next.number < 0 ? kink : time_ + next.value;
      combine();
    } else {
      if (!grows()) return QuasiStaticEnd::no_load;
      next = follow_path(kink);
    }
    if ((!is_linear_ || n_events_ > 0) && is_mechanism()) {
      take(last, last_time);
      return n_events_ > 0 ? QuasiStaticEnd::separated : QuasiStaticEnd::no_load;
    }
    come_to_rest();
    LoadState reached = measure(displacement_, time_);
    account.add_static_work(state, reached);
    // Friction took its part on the way; breaks account for theirs.
    const double lost = this->lost();
    account.add_relaxation(lost - std::exchange(lost_, lost));
    state = std::move(reached);
    if (on_equilibrium) on_equilibrium(state);
    if (next.number >= 0) return {};
    if (suspends()) return QuasiStaticEnd::suspended;
    const auto has_left = [&](const ToolState& tool) { return norm(tool.displacement) > tool_way * extent_; };
    const auto is_growing = [&](const UnitLoad& load) {
      return load.kind != UnitLoad::Kind::other && load.grows_after(time_);
    };
    // At such strains, whatever a stiff body carries is beyond the model.
    if (std::isinf(kink) && cuts_are_closed() && is_farther(displacement_, mechanism_displacement))
      return QuasiStaticEnd::no_load;
    if (std::ranges::any_of(state.tools, has_left) && std::ranges::none_of(unit_loads_, is_growing))
      return QuasiStaticEnd::no_load;
    if (!is_linear_) continue;
    group_->enter("static solve");
    solve_missing_problems({});
    group_->enter("quasi-static loading");
  }
}

bool QuasiStaticLoading::break_and_relax(EnergyAccount& account, const Critical& next, LoadState& state) {
  const auto n_counted = std::ssize(body_->breaks());
  const auto n_bridges = std::ssize(body_->bridge_releases());
  const std::size_t n_changes = body_->changes().size();
  for (const auto t : all_breaking(next))
    body_->release(t, body_->strain(t, displacement_.local()), time_, 0);
  law_->take_over(*body_, body_->changes().subspan(n_changes));
  parallel::check_peers(*group_);
  body_->release_bridges(*group_, time_, 0,
                         [&](std::int32_t t) { return body_->strain(t, displacement_.local()); });
  parallel::NodeField before(*group_, body_->subdomain().layout);
  before.assign(displacement_);
  const std::vector<double> unknowns_before = unknowns();
  ++n_events_;
  const std::int64_t n_before = n_breaks_;
  parallel::check_peers(*group_);
  n_breaks_ += parallel::all_reduce<std::int64_t>(*group_, std::ssize(body_->breaks()) - n_counted, MPI_SUM);
  if (n_before == 0 && n_breaks_ > 0) load_at_first_break_ = load_;
  const bool has_lost_bridges =
      parallel::any_of_all(*group_, std::ssize(body_->bridge_releases()) > n_bridges);
  if (!update_after_breaks(n_breaks_ > n_before || has_lost_bridges)) return false;
  account.add_relaxation(relaxation(before, unknowns_before));
  // At constant load only the loads on fragments that have not come loose still do work.
  state = with_unknowns(unknowns_before, [&] { return measure(before, time_); });
  // Friction lets go only after the state before has been measured.
  come_to_rest();
  lost_ = lost();
  LoadState relaxed = measure(displacement_, time_);
  account.add_static_work(state, relaxed);
  state = std::move(relaxed);
  return true;
}

bool QuasiStaticLoading::resume(double time, double kinetic, const parallel::NodeField& displacement,
                                EnergyAccount& account) {
  if (contact_ && (has_contact() || contact_->closes(displacement.local()))) {
    contact_->start();
    if (is_linear_) begin_increments();
  }
  // In motion the initial strain was constant.
  const LoadState held = measure(displacement, time);
  body_->set_time(time);
  account.add_static_work(held, measure(displacement, time));
  time_ = time;
  const std::vector<double> unknowns_before = unknowns();
  if (!update_after_breaks(true)) return false;
  account.add_relaxation(kinetic + relaxation(displacement, unknowns_before));
  // Counts only loads that still act.
  const LoadState before = with_unknowns(unknowns_before, [&] { return measure(displacement, time); });
  come_to_rest();
  lost_ = lost();
  account.add_static_work(before, measure(displacement_, time));
  return true;
}

}  // namespace crackle::dynamics
