// SPDX-License-Identifier: GPL-3.0-or-later
#include "stress_screening.h"

#include "common/index.h"

#include <algorithm>
#include <cmath>
#include <functional>
#include <numeric>
#include <utility>

namespace crackle::fracture {

namespace {

constexpr std::size_t groups_per_chunk = 64;
constexpr std::size_t chunk_size = 8 * groups_per_chunk;  // in tetrahedra
constexpr std::size_t groups_per_sum = 4096;
/// For unused lanes, which never become due.
constexpr double no_sensitivity = 1e-30;
/// With less of its strength left beside the initial stress, a tetrahedron is always due.
constexpr double least_left = 0.01;
/// Strains scaled by more than this or by less than its reciprocal are not squared.
constexpr double largest_scale = 0x1p20;

double power_of_two_below(double value) {
  return std::ldexp(1.0, std::ilogb(value));
}

/// Half diagonal of the bounding box of the movements of all nodes in these blocks.
double half_diagonal(std::span<const kernels::Movement<double>> movement,
                     std::span<const std::int32_t> blocks) {
  kernels::Movement<double> box = movement[index(blocks.front())];
  for (const auto block : blocks.subspan(1)) {
    for (std::size_t c = 0; c < 4; ++c) {
      box.low[c] = std::min(box.low[c], movement[index(block)].low[c]);
      box.high[c] = std::max(box.high[c], movement[index(block)].high[c]);
    }
  }
  double square = 0;
  for (std::size_t c = 0; c < 3; ++c) square += (box.high[c] - box.low[c]) * (box.high[c] - box.low[c]);
  return 0.5 * std::sqrt(square);
}

/// For tetrahedra whose strains are multiplied by their shear modulus over `shear`. The trace then has
/// another factor for each Poisson's ratio; the smallest and the largest bound all.
template <class Real>
kernels::StressBound<Real> stress_bound(const mechanics::ElasticityField& elasticity,
                                        const EquivalentStress& stress, double shear, double reference) {
  const auto [mean, j2] = stress.bound_factors();
  double least = infinity, greatest = -infinity;
  for (const auto& one : elasticity.values()) {
    const double bulk_modulus = one.bulk_modulus() / (one.mu / shear);
    least = std::min(least, bulk_modulus);
    greatest = std::max(greatest, bulk_modulus);
  }
  return {{static_cast<Real>(mean * least / reference), static_cast<Real>(mean * greatest / reference)},
          static_cast<Real>(std::sqrt(j2) * 2 * shear / reference)};
}

}  // namespace

template <class Real>
StressScreening<Real>::StressScreening(const geometry::Subdomain& subdomain,
                                       const mechanics::PdsOperators& operators,
                                       const mechanics::ElasticityField& elasticity,
                                       const EquivalentStress& stress, std::span<const double> strength,
                                       double share, std::vector<double> initial, double displacement_quantum,
                                       double energy_quantum, std::int32_t nodes_per_block,
                                       InstructionSet instruction_set)
    : n_tetrahedra_(subdomain.n_tetrahedra()),
      operators_(&operators),
      displacement_quantum_(displacement_quantum),
      energy_quantum_(energy_quantum),
      elasticity_(&elasticity),
      stress_(&stress),
      share_(share),
      initial_(std::move(initial)),
      reference_(strength.empty() ? 1 : power_of_two_below(strength.front())),
      reference_shear_(power_of_two_below(elasticity.values().front().mu)),
      instruction_set_(instruction_set),
      bound_(stress_bound<Real>(elasticity, stress, reference_shear_, share * reference_)),
      groups_((operators.tetrahedra.size() + 7) / 8, kernels::TetrahedronGroup<Real>{}),
      energy_factors_(groups_.size(), kernels::EnergyFactors<Real>{}),
      deadline_(groups_.size(), 0.0) {
  for (auto& group : groups_) std::ranges::fill(group.sensitivity, static_cast<Real>(no_sensitivity));
  std::vector<double> sensitivities;
  sensitivities.reserve(operators.tetrahedra.size());
  for (std::int32_t t = 0; t < n_tetrahedra_; ++t)
    sensitivities.push_back(sensitivity(t, left_strength(t, strength[index(t)])));
  sort_chunks(sensitivities);
  for (std::int32_t t = 0; t < n_tetrahedra_; ++t) {
    auto& group = groups_[place(t) / 8];
    for (std::size_t a = 0; a < 4; ++a) group.corner[a][place(t) % 8] = subdomain.tetrahedra[index(t)][a];
    const double scale = strain_scale(t, strength[index(t)]);
    if (subdomain.owned[index(t)] != 0 && scale < largest_scale && scale > 1 / largest_scale)
      set_energy(t, scale);
    set_strength(t, strength[index(t)]);
  }

  const auto n_owned_blocks = (subdomain.layout.n_owned + nodes_per_block - 1) / nodes_per_block;
  const auto block_of = [&](std::int32_t node) {
    return node < subdomain.layout.n_owned
               ? node / nodes_per_block
               : n_owned_blocks + (node - subdomain.layout.n_owned) / nodes_per_block;
  };
  for (std::size_t first = 0; first < groups_.size(); first += groups_per_chunk) {
    Chunk chunk{first, std::min(first + groups_per_chunk, groups_.size()), {}};
    for (std::size_t t = 8 * chunk.first_group;
         t < std::min(8 * chunk.last_group, operators.tetrahedra.size()); ++t)
      for (const auto node : subdomain.tetrahedra[t]) chunk.blocks.push_back(block_of(node));
    std::ranges::sort(chunk.blocks);
    chunk.blocks.erase(std::unique(chunk.blocks.begin(), chunk.blocks.end()), chunk.blocks.end());
    chunks_.push_back(std::move(chunk));
  }
  due_.resize(groups_.size() + 1);
  room_.resize(groups_.size());
}

template <class Real>
void StressScreening<Real>::sort_chunks(std::span<const double> sensitivity) {
  tetrahedron_.resize(sensitivity.size());
  place_.resize(sensitivity.size());
  for (std::size_t first = 0; first < sensitivity.size(); first += chunk_size) {
    const auto in_chunk =
        std::span(tetrahedron_).subspan(first, std::min(chunk_size, sensitivity.size() - first));
    std::iota(in_chunk.begin(), in_chunk.end(), std::int16_t{0});
    std::ranges::stable_sort(in_chunk, std::greater{},
                             [&](std::int16_t t) { return sensitivity[first + index(t)]; });
    for (std::size_t i = 0; i < in_chunk.size(); ++i)
      place_[first + index(in_chunk[i])] = static_cast<std::int16_t>(i);
  }
}

template <class Real>
std::size_t StressScreening<Real>::place(std::int32_t tetrahedron) const {
  const std::size_t t = index(tetrahedron);
  return t / chunk_size * chunk_size + index(place_[t]);
}

template <class Real>
std::span<const std::int32_t> StressScreening<Real>::candidates(
    std::span<const kernels::NodeRecord<Real>> nodes, std::span<const kernels::Movement<double>> movement) {
  candidates_.clear();
  const auto& kernels = kernels::kernels<Real>(instruction_set_);
  // All due groups are listed first, so that they can be fetched ahead.
  std::size_t n_due = 0;
  for (Chunk& chunk : chunks_) {
    chunk.clock += half_diagonal(movement, chunk.blocks);
    if (chunk.deadline > chunk.clock) continue;
    chunk.deadline = infinity;
    for (std::size_t group = chunk.first_group; group < chunk.last_group; ++group) {
      const bool is_due = !(deadline_[group] > chunk.clock);
      due_[n_due] = static_cast<std::uint32_t>(group);
      n_due += is_due ? 1 : 0;
      chunk.deadline = std::min(chunk.deadline, is_due ? infinity : deadline_[group]);
    }
  }
  kernels.check(groups_.data(), due_.data(), n_due, nodes.data(), bound_, room_.data());
  for (std::size_t i = 0; i < n_due; ++i) {
    const std::size_t group = due_[i];
    Chunk& chunk = chunks_[group / groups_per_chunk];
    if (room_[i] > 0) deadline_[group] = chunk.clock + static_cast<double>(room_[i]);
    chunk.deadline = std::min(chunk.deadline, deadline_[group]);
    if (room_[i] > 0) continue;
    const auto chunk_start = static_cast<std::int32_t>(8 * chunk.first_group);
    const auto first = static_cast<std::int32_t>(8 * group);
    for (std::int32_t place = first; place < std::min(first + 8, n_tetrahedra_); ++place)
      candidates_.push_back(chunk_start + tetrahedron_[index(place)]);
  }
  candidates_.insert(candidates_.end(), always_due_.begin(), always_due_.end());
  std::ranges::sort(candidates_);
  if (!always_due_.empty())
    candidates_.erase(std::unique(candidates_.begin(), candidates_.end()), candidates_.end());
  return candidates_;
}

template <class Real>
double StressScreening<Real>::left_strength(std::int32_t tetrahedron, double strength) const {
  if (initial_.empty()) return strength;
  const double left = strength - initial_[index(tetrahedron)] / share_;
  return left > least_left * strength ? left : 0;
}

template <class Real>
double StressScreening<Real>::sensitivity(std::int32_t tetrahedron, double strength) const {
  double sum = 0;
  for (const auto& gradient : operators_->tetrahedra[index(tetrahedron)].gradient) sum += norm(gradient);
  return stress_->sensitivity((*elasticity_)[tetrahedron]) / (share_ * reference_) * displacement_quantum_ *
         sum * (reference_ / strength);
}

template <class Real>
double StressScreening<Real>::strain_scale(std::int32_t tetrahedron, double strength) const {
  return (*elasticity_)[tetrahedron].mu / reference_shear_ * reference_ / strength;
}

template <class Real>
void StressScreening<Real>::set_strength(std::int32_t tetrahedron, double whole_strength) {
  const double strength = left_strength(tetrahedron, whole_strength);
  if (strength == 0) {
    exclude(tetrahedron);
    always_due_.insert(std::ranges::lower_bound(always_due_, tetrahedron), tetrahedron);
    return;
  }
  if (!always_due_.empty()) exclude(tetrahedron);
  auto& group = groups_[place(tetrahedron) / 8];
  const std::size_t lane = place(tetrahedron) % 8;
  // Stresses are in units of the tetrahedron's own strength.
  const auto& gradient = operators_->tetrahedra[index(tetrahedron)].gradient;
  const double scale = strain_scale(tetrahedron, strength);
  const double factor = displacement_quantum_ * scale;
  for (std::size_t a = 1; a < 4; ++a)
    for (std::size_t i = 0; i < 3; ++i)
      group.gradient[3 * (a - 1) + i][lane] = static_cast<Real>(gradient[a][i] * factor);
  if (has_energy(tetrahedron)) set_energy(tetrahedron, scale);
  // Rounded up, as it is an upper bound.
  const auto upper = static_cast<Real>(sensitivity(tetrahedron, strength) * (1 + 0x1p-20));
  const bool is_weaker = upper > std::exchange(group.sensitivity[lane], upper);
  if (!is_weaker || chunks_.empty()) return;
  deadline_[place(tetrahedron) / 8] = 0;
  chunks_[index(tetrahedron) / chunk_size].deadline = 0;
}

template <class Real>
void StressScreening<Real>::exclude(std::int32_t tetrahedron) {
  if (const auto due = std::ranges::lower_bound(always_due_, tetrahedron);
      due != always_due_.end() && *due == tetrahedron)
    always_due_.erase(due);
  auto& group = groups_[place(tetrahedron) / 8];
  const std::size_t lane = place(tetrahedron) % 8;
  for (auto& component : group.gradient) component[lane] = 0;
  group.sensitivity[lane] = static_cast<Real>(no_sensitivity);
}

template <class Real>
void StressScreening<Real>::set_energy(std::int32_t tetrahedron, double strain_scale) {
  const auto& [lambda, mu] = (*elasticity_)[tetrahedron];
  const double factor =
      operators_->tetrahedra[index(tetrahedron)].volume / (strain_scale * strain_scale * energy_quantum_);
  auto& factors = energy_factors_[place(tetrahedron) / 8];
  factors.trace[place(tetrahedron) % 8] = static_cast<Real>(0.5 * lambda * factor);
  factors.square[place(tetrahedron) % 8] = static_cast<Real>(mu * factor);
}

template <class Real>
bool StressScreening<Real>::has_energy(std::int32_t tetrahedron) const {
  return energy_factors_[place(tetrahedron) / 8].square[place(tetrahedron) % 8] != 0;
}

template <class Real>
void StressScreening<Real>::leave_out_energy(std::int32_t tetrahedron) {
  auto& factors = energy_factors_[place(tetrahedron) / 8];
  factors.trace[place(tetrahedron) % 8] = 0;
  factors.square[place(tetrahedron) % 8] = 0;
}

template <class Real>
__int128 StressScreening<Real>::energy(std::span<const kernels::NodeRecord<Real>> nodes) const {
  const auto& kernels = kernels::kernels<Real>(instruction_set_);
  __int128 sum = 0;
  for (std::size_t first = 0; first < groups_.size(); first += groups_per_sum) {
    const auto [high, low] = kernels.energy(groups_.data() + first, energy_factors_.data() + first,
                                            std::min(groups_per_sum, groups_.size() - first), nodes.data());
    sum += (static_cast<__int128>(high) << 50) + low;
  }
  return sum;
}

template class StressScreening<float>;
template class StressScreening<double>;

}  // namespace crackle::fracture
