// SPDX-License-Identifier: GPL-3.0-or-later
#include "terms.h"

#include "common/index.h"
#include "parallel/exact_sum.h"

#include "condition_terms.h"
#include "dampers.h"

#include <algorithm>
#include <stdexcept>

namespace crackle::dynamics {

namespace {

std::vector<std::unique_ptr<Term>> make_terms(const MotionContext& context, const MotionState& given,
                                              std::int32_t nodes_per_block) {
  std::vector<std::unique_ptr<Term>> terms;
  terms.push_back(std::make_unique<MotionTerm>(context, given, nodes_per_block));
  terms.push_back(std::make_unique<LoadTerm>(context, nodes_per_block));
  for (const MakeTerm& make : context.more_terms) terms.push_back(make(context, given, nodes_per_block));
  terms.push_back(std::make_unique<Dampers>(context, nodes_per_block));
  return terms;
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
  const auto n_owned = context.body->subdomain().layout.n_owned;
  acts_.resize(index(std::max(1, (n_owned + nodes_per_block - 1) / nodes_per_block)));
  for (std::size_t block = 0; block < acts_.size(); ++block)
    acts_[block] =
        std::ranges::any_of(terms_, [&](const auto& term) { return term->acts_on(block); }) ? 1 : 0;
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

void Terms::end_step(const mechanics::StepSpan& step, MovingNodes& nodes) {
  const Term::Drives drives = [&](const Term::Resistance& resistance) {
    for (const auto& term : terms_) term->move_against(step, resistance);
  };
  for (const auto& term : terms_) term->end_step(step, nodes, drives);
}

void Terms::end_loads(double time, const mechanics::NodesOfConditions& nodes, const MotionState& state) {
  for (const auto& term : terms_) term->end_loads(time, nodes, state);
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

double Terms::stored(const MotionState& state) const {
  if (std::ranges::none_of(terms_, [](const auto& term) { return term->stores(); })) return 0;
  std::vector<double> sum;
  for (const auto& term : terms_) term->add_stored(state, sum);
  return parallel::exact_sum(*group_, sum);
}

Demand Terms::demand(double from, double to) const {
  Demand demand;
  for (const auto& term : terms_) demand += term->demand(from, to);
  return demand;
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
