// SPDX-License-Identifier: GPL-3.0-or-later
#include "dampers.h"

#include "crackle/common/index.h"
#include "crackle/parallel/exact_sum.h"

#include <Eigen/LU>

#include <bit>
#include <map>
#include <stdexcept>

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

Dampers::Dampers(const MotionContext& context) : context_(context) {
  const auto& mass = context.body->operators().node_mass;
  if (act() || are_viscous()) memory_.resize(mass.size());
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

double Dampers::dissipated_energy() const {
  if (!act() && !are_viscous()) return 0;
  std::vector<double> terms;
  terms.reserve(memory_.size());
  for (const Memory& memory : memory_) terms.push_back(memory.dissipated);
  return parallel::exact_sum(*context_.group, terms);
}

void Dampers::save(MotionCheckpoint& checkpoint) const {
  parallel::NumberedRows local;
  local.width = 4;
  for (std::size_t n = 0; n < memory_.size(); ++n) {
    const Memory& memory = memory_[n];
    if (memory.dissipated == 0 && memory.remainder == std::array<double, 3>{}) continue;
    local.numbers.push_back(context_.body->subdomain().layout.number[n]);
    for (const double value : memory.remainder) local.values.push_back(std::bit_cast<std::int64_t>(value));
    local.values.push_back(std::bit_cast<std::int64_t>(memory.dissipated));
  }
  checkpoint.damped = parallel::gather_rows(*context_.group, local);
}

void Dampers::restore(const MotionCheckpoint& checkpoint) {
  for (std::size_t n = 0; n < memory_.size(); ++n) {
    memory_[n] = {};
    const auto row = checkpoint.damped.find(context_.body->subdomain().layout.number[n]);
    if (row.empty()) continue;
    for (std::size_t c = 0; c < 3; ++c) memory_[n].remainder[c] = std::bit_cast<double>(row[c]);
    memory_[n].dissipated = std::bit_cast<double>(row[3]);
  }
}

}  // namespace crackle::dynamics
