// SPDX-License-Identifier: GPL-3.0-or-later
#include "dampers.h"

#include "common/index.h"

#include <Eigen/LU>

#include <algorithm>
#include <bit>
#include <cmath>
#include <map>
#include <utility>

namespace crackle::dynamics {

namespace {

Eigen::Matrix3d matrix_of(const mechanics::Symmetric& s) {
  Eigen::Matrix3d matrix;
  matrix << s[0], s[5], s[4], s[5], s[1], s[3], s[4], s[3], s[2];
  return matrix;
}

mechanics::Symmetric symmetric_of(const Eigen::Matrix3d& m) {
  return {m(0, 0), m(1, 1), m(2, 2), m(1, 2), m(0, 2), m(0, 1)};
}

}  // namespace

Dampers::Dampers(const MotionContext& context, std::int32_t nodes_per_block)
    : context_(context),
      nodes_per_block_(nodes_per_block),
      viscosity_(context.body->subdomain(), context.body->operators(), context.body->material(),
                 context.bulk_viscosity),
      moved_(context.bulk_viscosity.acts() ? context.body->subdomain().nodes.size() : 0),
      viscous_force_(moved_.size()) {
  const auto& mass = context.body->operators().node_mass;
  if (dissipates()) memory_.resize(mass.size());
  if (!act()) return;
  const auto& loads = *context.loads;
  std::map<std::int32_t, Eigen::Matrix3d> rates;
  const auto rate_of = [&](std::int32_t node) -> auto& {
    return rates.try_emplace(node, context.damping_rate * Eigen::Matrix3d::Identity()).first->second;
  };
  for (const auto& absorber : loads.absorbers)
    for (std::size_t n = 0; n < absorber.nodes.size(); ++n)
      rate_of(absorber.nodes[n]) += matrix_of(absorber.impedance[n]) / mass[index(absorber.nodes[n])];
  for (const auto& motion : loads.motions) {
    for (const auto node : motion.nodes) {
      Eigen::Matrix3d& rate = rate_of(node);
      rate.row(motion.component).setZero();
      rate.col(motion.component).setZero();
    }
  }
  for (const auto& [node, rate] : rates) nodes_.push_back({node, symmetric_of(rate), {}});
}

void Dampers::set_duration(double duration) {
  if (duration == duration_) return;
  duration_ = duration;
  const double half = 0.5 * duration;
  change_ = -2 * half * context_.damping_rate / (1 + half * context_.damping_rate);
  for (Node& node : nodes_) {
    const Eigen::Matrix3d b = half * matrix_of(node.rate);
    const Eigen::Matrix3d change = -2 * (Eigen::Matrix3d::Identity() + b).inverse() * b;
    for (Eigen::Index i = 0; i < 3; ++i)
      for (Eigen::Index k = 0; k < 3; ++k) node.change[index(i)][index(k)] = change(i, k);
  }
}

template <class Change>
void Dampers::slow_down(std::int32_t node, MovingNodes& nodes, double duration, const Change& change) {
  Memory& memory = memory_[index(node)];
  std::array<double, 3> before{};
  for (int c = 0; c < 3; ++c) before[index(c)] = nodes.velocity(node, c);
  double lost = 0;  // decrease of the squared velocity
  for (int c = 0; c < 3; ++c) {
    double& remainder = memory.remainder[index(c)];
    const double wanted = change(before, index(c)) + remainder;
    const double changed = nodes.change_velocity(node, c, wanted, duration);
    remainder = wanted - changed;
    lost -= changed * (2 * before[index(c)] + changed);
  }
  memory.dissipated += 0.5 * context_.body->operators().node_mass[index(node)] * lost;
}

void Dampers::after_drift(std::size_t block, const Substep& substep, MovingNodes& nodes) {
  if (!act()) return;
  set_duration(substep.drift);
  const auto first = static_cast<std::int32_t>(block) * nodes_per_block_;
  const auto last = std::min(first + nodes_per_block_, context_.body->subdomain().layout.n_owned);
  auto special = std::ranges::lower_bound(nodes_, first, {}, &Node::node);
  for (std::int32_t n = first; n < last; ++n) {
    if (special != nodes_.end() && special->node == n) {
      const auto& change = special->change;
      slow_down(n, nodes, 0.5 * substep.drift, [&](const std::array<double, 3>& v, std::size_t c) {
        return change[c][0] * v[0] + change[c][1] * v[1] + change[c][2] * v[2];
      });
      ++special;
    } else if (change_ != 0) {
      slow_down(n, nodes, 0.5 * substep.drift,
                [&](const std::array<double, 3>& v, std::size_t c) { return change_ * v[c]; });
    }
  }
}

void Dampers::end_step(const mechanics::StepSpan& step, MovingNodes& nodes, const Drives& drives) {
  if (moved_.empty()) return;
  const double duration = step.end - step.begin, quantum = nodes.force_quantum();
  nodes.movements(moved_);
  std::ranges::fill(viscous_force_, Vector{});
  viscosity_.find(
      context_.body->residual_stiffness(), duration,
      [&](std::int32_t a, std::int32_t b, std::size_t i) {
        return moved_[index(a)][i] - moved_[index(b)][i];
      },
      [&](double value) { return quantum > 0 ? quantum * std::rint(value / quantum) : value; },
      [&](std::int32_t node, std::size_t i, double value) { viscous_force_[index(node)][i] += value; });
  drives([&](std::int32_t node, int component, double displacement) {
    const double force = std::exchange(viscous_force_[index(node)][index(component)], 0.0);
    memory_[index(node)].dissipated += displacement * force;
    return force;
  });
  const auto& mass = context_.body->operators().node_mass;
  for (std::size_t n = 0; n < memory_.size(); ++n) {
    const double per_force = -duration / mass[n];
    slow_down(static_cast<std::int32_t>(n), nodes, 0,
              [&](const std::array<double, 3>&, std::size_t c) { return per_force * viscous_force_[n][c]; });
  }
}

void Dampers::add_dissipated(std::vector<double>& sum) const {
  for (const Memory& memory : memory_) sum.push_back(memory.dissipated);
}

void Dampers::measure(double, const parallel::NodeField&, const parallel::NodeField* velocity,
                      LoadState& state) const {
  if (velocity != nullptr) measure_absorbers(*context_.group, *context_.loads, *velocity, state);
}

std::vector<parallel::NumberedRows> Dampers::save() const {
  parallel::NumberedRows local;
  local.width = 4;
  for (std::size_t n = 0; n < memory_.size(); ++n) {
    const Memory& memory = memory_[n];
    if (memory.dissipated == 0 && memory.remainder == std::array<double, 3>{}) continue;
    local.numbers.push_back(context_.body->subdomain().layout.number[n]);
    for (const double value : memory.remainder) local.values.push_back(std::bit_cast<std::int64_t>(value));
    local.values.push_back(std::bit_cast<std::int64_t>(memory.dissipated));
  }
  return {parallel::gather_rows(*context_.group, local)};
}

void Dampers::restore(const std::vector<parallel::NumberedRows>& rows) {
  for (std::size_t n = 0; n < memory_.size(); ++n) {
    memory_[n] = {};
    const auto row = rows.at(0).find(context_.body->subdomain().layout.number[n]);
    if (row.empty()) continue;
    for (std::size_t c = 0; c < 3; ++c) memory_[n].remainder[c] = std::bit_cast<double>(row[c]);
    memory_[n].dissipated = std::bit_cast<double>(row[3]);
  }
}

}  // namespace crackle::dynamics
