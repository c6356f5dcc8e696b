// SPDX-License-Identifier: GPL-3.0-or-later
#include "terms.h"

#include "common/index.h"
#include "parallel/agreement.h"
#include "parallel/exact_sum.h"
#include "parallel/ghost_exchange.h"

#include "condition_terms.h"
#include "contact_term.h"
#include "dampers.h"

#include <algorithm>
#include <array>
#include <iterator>
#include <stdexcept>
#include <utility>

namespace crackle::dynamics {

namespace {

using List = std::vector<std::unique_ptr<Term>>;

List make_terms(const MotionContext& context, const MotionState& given, std::int32_t nodes_per_block) {
  List terms;
  terms.push_back(std::make_unique<LoadTerm>(context, nodes_per_block));
  for (const MakeTerm& make : context.more_terms) terms.push_back(make(context, given, nodes_per_block));
  terms.push_back(std::make_unique<MotionTerm>(context, given, nodes_per_block));
  return terms;
}

/// The sums at each node, ascending.
std::vector<NodeResponse> sums_of(std::vector<NodeResponse> all) {
  std::vector<NodeResponse> sums;
  std::ranges::stable_sort(all, {}, &NodeResponse::node);
  for (const NodeResponse& one : all) {
    if (sums.empty() || sums.back().node != one.node) {
      sums.push_back(one);
      continue;
    }
    for (std::size_t i = 0; i < 3; ++i) sums.back().force[i] += one.force[i];
    for (std::size_t i = 0; i < 6; ++i) sums.back().stiffness[i] += one.stiffness[i];
  }
  return sums;
}

}  // namespace

Demand& Demand::operator+=(const Demand& other) {
  stress = std::max(stress, other.stress);
  velocity = std::max(velocity, other.velocity);
  acceleration += other.acceleration;
  resultant += other.resultant;
  holds = holds || other.holds;
  return *this;
}

Terms::Terms(const MotionContext& context, const MotionState& given, std::int32_t nodes_per_block)
    : group_(context.group), terms_(make_terms(context, given, nodes_per_block)) {
  if (context.body->has_contact()) terms_.push_back(std::make_unique<ContactTerm>(context));
  terms_.push_back(std::make_unique<Dampers>(context, nodes_per_block));
  const auto n_owned = context.body->subdomain().layout.n_owned;
  acts_.resize(index(std::max(1, (n_owned + nodes_per_block - 1) / nodes_per_block)));
  find_blocks();
}

void Terms::find_blocks() {
  for (std::size_t block = 0; block < acts_.size(); ++block)
    acts_[block] =
        std::ranges::any_of(terms_, [&](const auto& term) { return term->acts_on(block); }) ? 1 : 0;
}

Terms::Terms(const MotionContext& context) : group_(context.group) {
  const auto& layout = context.body->subdomain().layout;
  const MotionState none{parallel::NodeField(*context.group, layout),
                         parallel::NodeField(*context.group, layout)};
  terms_ = make_terms(context, none, std::max(1, layout.n_owned));
  terms_.push_back(std::make_unique<InitialStrainTerm>(context));
}

void Terms::prescribe(double time, MotionState& state) const {
  for (const auto& term : terms_) term->prescribe(time, state);
}

void Terms::start(double time, const MotionState& state) {
  for (const auto& term : terms_) term->start(time, state);
}

void Terms::before_kick(std::size_t block, const Substep& substep, MovingNodes& nodes) {
  for (const auto& term : terms_) term->before_kick(block, substep, nodes);
}

void Terms::after_kick(std::size_t block, const Substep& substep, MovingNodes& nodes) {
  for (const auto& term : terms_) term->after_kick(block, substep, nodes);
}

void Terms::after_drift(std::size_t block, const Substep& substep, MovingNodes& nodes) {
  for (const auto& term : terms_) term->after_drift(block, substep, nodes);
}

bool Terms::couple_nodes() const {
  return std::ranges::any_of(terms_, [](const auto& term) { return term->couples_nodes(); });
}

void Terms::add_forces(MovingNodes& nodes) {
  for (const auto& term : terms_) term->add_forces(nodes);
}

void Terms::end_step(const mechanics::StepSpan& step, MovingNodes& nodes) {
  const Term::Drives drives = [&](const Term::Resistance& resistance) {
    for (const auto& term : terms_) term->move_against(step, resistance);
  };
  bool is_elsewhere = false;
  for (const auto& term : terms_) {
    term->end_step(step, nodes, drives);
    is_elsewhere = term->acts_elsewhere() || is_elsewhere;
  }
  if (is_elsewhere) find_blocks();
}

void Terms::end_loads(double time, const mechanics::NodesOfConditions& nodes,
                      const parallel::NodeField& displacement) {
  for (const auto& term : terms_) term->end_loads(time, nodes, displacement);
}

double Terms::supplied(double time, const MotionState& state) const {
  std::vector<double> sum;
  for (const auto& term : terms_) term->add_supplied(time, state, sum);
  return parallel::exact_sum(*group_, sum);
}

double Terms::dissipated() const {
  if (std::ranges::none_of(terms_, [](const auto& term) { return term->dissipates(); })) return 0;
  std::vector<double> sum;
  for (const auto& term : terms_) term->add_dissipated(sum);
  return parallel::exact_sum(*group_, sum);
}

double Terms::stored(const parallel::NodeField& displacement) const {
  if (std::ranges::none_of(terms_, [](const auto& term) { return term->stores(); })) return 0;
  std::vector<double> sum;
  for (const auto& term : terms_) term->add_stored(displacement, sum);
  return parallel::exact_sum(*group_, sum);
}

double Terms::lost_at_rest(const parallel::NodeField& displacement) const {
  std::vector<double> sum;
  for (const auto& term : terms_) term->add_lost_at_rest(displacement, sum);
  return parallel::exact_sum(*group_, sum);
}

LoadState Terms::measure(double time, const parallel::NodeField& displacement,
                         const parallel::NodeField* velocity) const {
  LoadState state;
  for (const auto& term : terms_) term->measure(time, displacement, velocity, state);
  return state;
}

Demand Terms::demand(double from, double to) const {
  Demand demand;
  for (const auto& term : terms_) demand += term->demand(from, to);
  return demand;
}

std::vector<UnitLoad> Terms::unit_loads() const {
  std::vector<UnitLoad> loads;
  for (const auto& term : terms_) term->add_unit_loads(loads);
  std::ranges::stable_sort(loads, {}, &UnitLoad::kind);
  return loads;
}

mechanics::HeldComponents Terms::held_components(const geometry::Subdomain& subdomain) const {
  using OfNode = std::array<std::uint8_t, 3>;
  std::vector<OfNode> marks(subdomain.nodes.size());
  mechanics::HeldComponents held(3 * marks.size());
  for (const auto& term : terms_) term->mark_held(held);
  for (std::size_t i = 0; i < held.size(); ++i) marks[i / 3][i % 3] = held[i];
  parallel::GhostExchange<OfNode> exchange(*group_, subdomain.layout);
  parallel::check_peers(*group_);
  exchange.update(marks);
  for (std::size_t i = 0; i < held.size(); ++i) held[i] = marks[i / 3][i % 3];
  return held;
}

std::vector<NodeResponse> Terms::responses(double time, std::span<const double> displacement) const {
  std::vector<NodeResponse> all;
  for (const auto& term : terms_) term->add_responses(time, displacement, all);
  return sums_of(std::move(all));
}

std::vector<double*> Terms::unknowns() const {
  std::vector<double*> all;
  for (const auto& term : terms_) std::ranges::copy(term->unknowns(), std::back_inserter(all));
  return all;
}

std::vector<UnknownResponse> Terms::unknown_responses(double time,
                                                      std::span<const double> displacement) const {
  std::vector<UnknownResponse> all;
  for (const auto& term : terms_) term->add_unknown_responses(time, displacement, all);
  return all;
}

std::vector<NodeResponse> Terms::stiffest(std::span<const double> no_displacement) const {
  std::vector<NodeResponse> all;
  for (const auto& term : terms_) term->add_stiffest(no_displacement, all);
  return sums_of(std::move(all));
}

void Terms::save(MotionCheckpoint& checkpoint) const {
  for (const auto& term : terms_) checkpoint.terms.push_back(term->save());
}

void Terms::restore(const MotionCheckpoint& checkpoint) {
  if (checkpoint.terms.size() != terms_.size())
    throw std::runtime_error("the checkpoint has a different number of terms");
  for (std::size_t k = 0; k < terms_.size(); ++k) terms_[k]->restore(checkpoint.terms[k]);
}

}  // namespace crackle::dynamics
