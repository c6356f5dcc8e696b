// SPDX-License-Identifier: GPL-3.0-or-later
#include "boundary_nodes.h"

#include "crackle/common/index.h"

#include <algorithm>
#include <cmath>
#include <optional>

namespace crackle::dynamics {

template <class Real>
BoundaryNodes<Real>::BoundaryNodes(const MotionContext& context, const mechanics::FixedPointScale& scale,
                                   std::int32_t nodes_per_block, FixedPointState<Real>& state,
                                   ExternalWork& work)
    : context_(context),
      scale_(scale),
      state_(&state),
      work_(&work),
      blocks_((state.velocity().size() + index(nodes_per_block) - 1) / index(nodes_per_block)) {
  const auto entry_of = [](std::size_t condition, std::size_t place, std::int32_t node, int component) {
    return Entry{.condition = static_cast<std::uint32_t>(condition),
                 .place = static_cast<std::uint32_t>(place),
                 .node = node,
                 .component = static_cast<std::int16_t>(component),
                 .is_driven = true,
                 .velocity = 0,
                 .remainder = 0,
                 .per_impulse = 0};
  };
  const auto& mass = context_.body->operators().node_mass;
  for (std::size_t k = 0; k < context_.loads->forces.size(); ++k) {
    const auto& pattern = context_.loads->forces[k];
    for (std::size_t n = 0; n < pattern.nodes.size(); ++n) {
      Entry entry = entry_of(k, n, pattern.nodes[n], pattern.component);
      entry.is_driven = !pattern.does_work_at(n);
      entry.per_impulse = 1 / (mass[index(entry.node)] * scale_.velocity);
      blocks_[index(entry.node / nodes_per_block)].loaded.push_back(entry);
    }
  }
  for (std::size_t m = 0; m < context_.loads->motions.size(); ++m) {
    const auto& motion = context_.loads->motions[m];
    for (std::size_t n = 0; n < motion.nodes.size(); ++n)
      blocks_[index(motion.nodes[n] / nodes_per_block)].driven.push_back(
          entry_of(m, n, motion.nodes[n], motion.component));
  }
}

template <class Real>
void BoundaryNodes<Real>::before_kick(std::size_t block, const Substep& substep) {
  for (Entry& entry : blocks_[block].driven) keep_velocity(entry, substep);
}

template <class Real>
void BoundaryNodes<Real>::after_kick(std::size_t block, const Substep& substep) {
  for (const Entry& entry : blocks_[block].driven) velocity(entry) = entry.velocity;
  // The entries of a pattern follow each other.
  std::optional<std::size_t> pattern;
  Amplitude amplitude{};
  for (Entry& entry : blocks_[block].loaded) {
    if (pattern != entry.condition) {
      pattern = entry.condition;
      const mechanics::LoadCurve& curve = context_.loads->forces[*pattern].amplitude;
      amplitude = {curve.at(substep.kick_time), curve.slope(substep.kick_time, substep.step)};
    }
    kick_by_load(entry, substep, amplitude);
  }
}

template <class Real>
void BoundaryNodes<Real>::after_drift(std::size_t block, const Substep& substep,
                                      kernels::Movement<double>& movement) {
  for (const Entry& entry : blocks_[block].driven) {
    const double displacement = drive(entry, substep);
    movement.low[entry.component] = std::min(movement.low[entry.component], -displacement);
    movement.high[entry.component] = std::max(movement.high[entry.component], displacement);
  }
}

template <class Real>
void BoundaryNodes<Real>::save(MotionCheckpoint& checkpoint) const {
  std::vector<const std::vector<std::int32_t>*> nodes;
  std::vector<std::vector<double>> remainders;
  for (const auto& pattern : context_.loads->forces) {
    nodes.push_back(&pattern.nodes);
    remainders.emplace_back(pattern.nodes.size(), 0.0);
  }
  for (const Block& block : blocks_)
    for (const Entry& entry : block.loaded) remainders[entry.condition][entry.place] = entry.remainder;
  checkpoint.remainder = gather_at_nodes(context_, nodes, remainders);
}

template <class Real>
void BoundaryNodes<Real>::restore(const MotionCheckpoint& checkpoint) {
  const auto& number = context_.body->subdomain().layout.number;
  for (Block& block : blocks_)
    for (Entry& entry : block.loaded)
      entry.remainder = checkpoint.remainder.at(entry.condition).number_at(number[index(entry.node)]);
}

template <class Real>
typename BoundaryNodes<Real>::Integer& BoundaryNodes<Real>::velocity(const Entry& entry) {
  return state_->velocity()[index(entry.node)].value[entry.component];
}

template <class Real>
void BoundaryNodes<Real>::keep_velocity(Entry& entry, const Substep& substep) {
  entry.velocity = velocity(entry);
  const auto& motion = context_.loads->motions[entry.condition];
  const double prescribed = motion.factor_at(entry.place) * motion.velocity(substep.kick_time, substep.step);
  if (prescribed == 0) return;
  const auto force = state_->nodes()[index(entry.node)].force[entry.component];
  work_->add_reaction(entry.condition, entry.place, substep.kick * prescribed,
                      scale_.force * static_cast<double>(force));
}

template <class Real>
void BoundaryNodes<Real>::kick_by_load(Entry& entry, const Substep& substep, const Amplitude& amplitude) {
  const auto& pattern = context_.loads->forces[entry.condition];
  if (amplitude.slope != 0) {
    const std::int64_t displacement = state_->whole_displacement(index(entry.node), index(entry.component));
    work_->add_rate(entry.condition, entry.place, substep.kick * amplitude.slope,
                    scale_.displacement * static_cast<double>(displacement));
  }
  if (entry.is_driven) return;
  const double force = amplitude.value * pattern.weight[entry.place];
  // A constant load would be rounded the same way in every kick, so the remainder is carried over.
  const double change = substep.kick * force * entry.per_impulse + entry.remainder;
  const auto rounded = quantized<Integer>(change, 1, stays_in_range_);
  entry.remainder = change - static_cast<double>(rounded);
  if (__builtin_add_overflow(velocity(entry), rounded, &velocity(entry))) stays_in_range_ = false;
}

template <class Real>
double BoundaryNodes<Real>::drive(const Entry& entry, const Substep& substep) {
  const auto& motion = context_.loads->motions[entry.condition];
  const double factor = motion.factor_at(entry.place);
  const double speed = factor * motion.velocity(substep.drift_time);
  auto& place = state_->nodes()[index(entry.node)].displacement[entry.component];
  const Integer before = place;
  place = low_digits<Real>(quantized<std::int64_t>(factor * motion.displacement(substep.drift_time),
                                                   scale_.displacement, stays_in_range_));
  velocity(entry) = quantized<Integer>(speed, scale_.velocity, stays_in_range_);
  // During the drift the node moved by factor times velocity from the start of the step; the sum bounds its
  // movement.
  return std::abs(static_cast<double>(kernels::difference(place, before))) +
         std::abs(substep.drift * speed) / scale_.displacement + 2;
}

template class BoundaryNodes<float>;
template class BoundaryNodes<double>;

}  // namespace crackle::dynamics
