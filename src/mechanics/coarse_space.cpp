// SPDX-License-Identifier: GPL-3.0-or-later
#include "coarse_space.h"

#include "common/index.h"
#include "parallel/agreement.h"
#include "parallel/collectives.h"
#include "parallel/reproducible.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <limits>
#include <numeric>

namespace crackle::mechanics {

namespace {

using kernels::CellIntegers;
using kernels::CellNumbers;
using kernels::lane_of;
using kernels::n_motions;
using kernels::n_shares;

/// Stiffness added to every coarse unknown, relative to the largest entry: cells whose nodes are collinear or
/// have come loose make the matrix singular.
constexpr double regularization = 1e-10;
/// Bits of the coarse matrix's integers below the largest term: thousands of terms fit 64 bits.
constexpr int matrix_digits = 36;
constexpr double whole = NodeCells::whole;

/// A block of the coarse matrix during summation.
using BlockSum = std::array<CellIntegers, n_motions>;

/// The lower triangle of the coarse matrix, in rows of cells.
class BlockSums {
public:
  explicit BlockSums(std::int32_t n_cells) : rows_(index(n_cells)) {}

  /// @pre column <= row
  BlockSum& at(std::int32_t row, std::int32_t column) {
    auto& entries = rows_[index(row)];
    const auto place = std::ranges::find(entries, column, &Entry::column);
    if (place != entries.end()) return blocks_[place->block];
    entries.push_back({column, blocks_.size()});
    return blocks_.emplace_back();
  }
  template <class Work>
  void for_each(const Work& work) const {
    for (std::size_t row = 0; row < rows_.size(); ++row)
      for (const Entry& entry : rows_[row])
        work(static_cast<std::int32_t>(row), entry.column, blocks_[entry.block]);
  }

private:
  struct Entry {
    std::int32_t column;
    std::size_t block;
  };
  std::vector<std::vector<Entry>> rows_;
  std::vector<BlockSum> blocks_;
};

/// The sums of all ranks on every rank. Collective.
BlockSums sum_of_all(const parallel::Communicator& group, const BlockSums& mine, std::int32_t n_cells) {
  std::vector<std::int64_t> packed;
  mine.for_each([&](std::int32_t row, std::int32_t column, const BlockSum& block) {
    packed.push_back(row);
    packed.push_back(column);
    for (const auto& numbers : block)
      for (std::size_t n = 0; n < n_motions; ++n) packed.push_back(numbers.value[lane_of(n)]);
  });
  const auto all = parallel::gather_all<std::int64_t>(group, packed);
  BlockSums sums(n_cells);
  constexpr std::size_t stride = 2 + n_motions * n_motions;
  for (std::size_t at = 0; at < all.size(); at += stride) {
    BlockSum& block = sums.at(static_cast<std::int32_t>(all[at]), static_cast<std::int32_t>(all[at + 1]));
    for (std::size_t k = 0; k < n_motions * n_motions; ++k)
      block[k / n_motions].value[lane_of(k % n_motions)] += all[at + 2 + k];
  }
  return sums;
}

/// Includes the factor 2 of shear components, so that stress . strain is twice the energy.
using StiffnessMatrix = std::array<double[6], 6>;
template <class StressOfStrain>
StiffnessMatrix stiffness_matrix(const StressOfStrain& stress, double factor) {
  StiffnessMatrix matrix{};
  for (std::size_t l = 0; l < 6; ++l) {
    Symmetric unit{};
    unit[l] = 1;
    const Symmetric sigma = stress(unit);
    for (std::size_t k = 0; k < 6; ++k) matrix[k][l] = factor * (k < 3 ? 1 : 2) * sigma[k];
  }
  return matrix;
}

/// The cells in which a tetrahedron's corners have shares.
struct CornerShares {
  std::vector<kernels::CornerShare> shares;
  std::vector<std::int32_t> cells;
  bool is_free = true;  // no component of a corner is constrained

  int place_of(std::int32_t cell) {
    const auto place = std::ranges::find(cells, cell) - cells.begin();
    if (place == std::ssize(cells)) cells.push_back(cell);
    return static_cast<int>(place);
  }
};

}  // namespace

CoarseSpace::CoarseSpace(const parallel::Communicator& group, const geometry::Subdomain& subdomain,
                         const Edges& edges, std::span<const std::uint8_t> constrained)
    : group_(&group),
      subdomain_(&subdomain),
      constrained_(constrained),
      kernels_(&kernels::cell_kernels(best_instruction_set())),
      cells_(make_node_cells(group, subdomain, edges)),
      numbers_(index(cells_.size())),
      packed_(n_motions * index(cells_.size())),
      factors_(cells_.size()) {
  order_nodes();
  const Vector middle = 0.5 * (cells_.box.lower + cells_.box.upper);
  const Vector side = cells_.box.upper - cells_.box.lower;
  const double half_length = std::max({side[0], side[1], side[2], std::numeric_limits<double>::min()}) / 2;
  const auto scaled = [&](const geometry::Point& p) { return (1 / half_length) * (p - middle); };
  std::vector<std::int64_t> weight(index(cells_.size()));
  for (auto& node : nodes_) {
    const Vector at = scaled(subdomain.nodes[index(node.node)]);
    for (std::size_t i = 0; i < 3; ++i) node.place[i] = static_cast<float>(at[i]);
    const auto& shares = cells_.shares[index(node.node)];
    for (std::size_t s = 0; s < n_shares; ++s) weight[index(shares.cell[s])] += shares.weight[s];
  }
  for (std::size_t c = 0; c < weight.size(); ++c) {
    centre_.push_back(scaled(cells_.centre[c]));
    magnification_.push_back(half_length / cells_.extent[c]);
  }
  parallel::check_peers(group);
  if (!weight.empty()) parallel::all_reduce(group, weight, MPI_SUM);
  // Sums of integers that fit a double are exact in any order. A moment is less than twice the force.
  const std::int64_t heaviest = weight.empty() ? 1 : std::ranges::max(weight);
  digits_ = 52 - static_cast<int>(std::bit_width(static_cast<std::uint64_t>(heaviest)));
}

void CoarseSpace::order_nodes() {
  const auto n_owned = subdomain_->layout.n_owned;
  std::vector<std::int32_t> order(index(n_owned));
  std::iota(order.begin(), order.end(), 0);
  std::ranges::stable_sort(order, {}, [&](std::int32_t node) { return cells_.shares[index(node)].cell; });
  position_.resize(order.size());
  for (const auto node : order) {
    const auto& shares = cells_.shares[index(node)];
    if (groups_.empty() || !std::ranges::equal(groups_.back().cell, shares.cell)) {
      std::ranges::copy(shares.cell, groups_.emplace_back().cell);
      groups_.back().n_nodes = 0;
    }
    ++groups_.back().n_nodes;
    position_[index(node)] = static_cast<std::int32_t>(nodes_.size());
    auto& placed = nodes_.emplace_back();
    placed.node = node;
    for (std::size_t s = 0; s < n_shares; ++s) placed.weight[s] = static_cast<float>(shares.weight[s]);
  }
}

void CoarseSpace::factorize(const PdsOperators& operators, const ElasticityField& elasticity,
                            const ResidualStiffness& residual_stiffness,
                            std::span<const NodeStiffness> springs) {
  // A tetrahedron's coarse entries are bounded by its stiffness bound times the motions, which are of order
  // 1.
  double bound = stiffness_bound(operators, elasticity);
  for (const NodeStiffness& spring : springs)
    bound = std::max(bound, spring.stiffness[0] + spring.stiffness[1] + spring.stiffness[2]);
  parallel::check_peers(*group_);
  const double stiffest = parallel::largest_of_all(*group_, bound);
  const double scale = std::ldexp(1.0, matrix_digits - std::ilogb(stiffest));

  BlockSums mine(cells_.size());
  CornerShares corners;
  std::vector<CellNumbers> strain, stress;
  for (std::size_t number = 0; number < operators.tetrahedra.size(); ++number) {
    const auto tetrahedron = static_cast<std::int32_t>(number);
    if (!residual_stiffness.carries(tetrahedron) || subdomain_->owned[number] == 0) continue;
    const auto& t = operators.tetrahedra[number];
    corners.shares.clear();
    corners.cells.clear();
    corners.is_free = true;
    for (std::size_t a = 0; a < 4; ++a) {
      const auto node = index(t.nodes[a]);
      const std::uint8_t* is_constrained = &constrained_[3 * node];
      corners.is_free = corners.is_free && is_constrained[0] + is_constrained[1] + is_constrained[2] == 0;
      const auto& shares = cells_.shares[node];
      for (std::size_t s = 0; s < n_shares; ++s) {
        if (shares.weight[s] == 0) continue;
        const auto c = index(shares.cell[s]);
        auto& corner = corners.shares.emplace_back();
        corner.cell = corners.place_of(shares.cell[s]);
        for (std::size_t i = 0; i < 3; ++i) {
          corner.gradient[i] = t.gradient[a][i];
          corner.free[i] = is_constrained[i] != 0 ? 0 : shares.weight[s] / whole;
          corner.arm[i] = (subdomain_->nodes[node][i] - cells_.centre[c][i]) / cells_.extent[c];
        }
      }
    }
    const std::size_t n_cells = corners.cells.size();
    if (n_cells == 1 && corners.is_free) continue;  // moves rigidly
    strain.resize(6 * n_cells);
    stress.resize(6 * n_cells);
    const double factor = scale * t.volume;
    const StiffnessMatrix stiffness =
        residual_stiffness.is_intact(tetrahedron)
            ? stiffness_matrix(elasticity[tetrahedron], factor)
            : stiffness_matrix([&](const Symmetric& e) { return residual_stiffness.stress(tetrahedron, e); },
                               factor);
    kernels_->find_strains(corners.shares.data(), corners.shares.size(), n_cells, stiffness.data(),
                           strain.data(), stress.data());
    for (std::size_t p = 0; p < n_cells; ++p)
      for (std::size_t q = 0; q < n_cells; ++q)
        if (corners.cells[q] <= corners.cells[p])
          kernels_->add_energies(&stress[6 * p], &strain[6 * q],
                                 mine.at(corners.cells[p], corners.cells[q]).data());
  }
  for (const NodeStiffness& spring : springs) add_spring(spring, scale, mine);
  const BlockSums sums = group_->size() > 1 ? sum_of_all(*group_, mine, cells_.size()) : std::move(mine);

  std::vector<PlacedBlock> blocks;
  double largest_entry = 0;
  sums.for_each([&](std::int32_t row, std::int32_t column, const BlockSum& sum) {
    PlacedBlock& placed = blocks.emplace_back();
    placed.row = row;
    placed.column = column;
    for (std::size_t m = 0; m < n_motions; ++m)
      for (std::size_t n = 0; n < n_motions; ++n)
        placed.block(static_cast<int>(m), static_cast<int>(n)) =
            static_cast<double>(sum[m].value[lane_of(n)]) / scale;
    largest_entry = std::max(largest_entry, placed.block.cwiseAbs().maxCoeff());
  });
  for (std::int32_t c = 0; c < cells_.size(); ++c)
    blocks.push_back({c, c, Block::Identity() * (regularization * largest_entry)});
  factors_.factorize(blocks);
}

template <class BlockSums>
void CoarseSpace::add_spring(const NodeStiffness& spring, double scale, BlockSums& sums) const {
  const auto node = index(spring.node);
  const auto& shares = cells_.shares[node];
  std::array<std::array<Vector, n_motions>, n_shares> moved{};  // the node, by the motions of its cells
  for (std::size_t s = 0; s < n_shares; ++s) {
    const auto c = index(shares.cell[s]);
    const Vector arm = (1 / cells_.extent[c]) * (subdomain_->nodes[node] - cells_.centre[c]);
    for (std::size_t m = 0; m < n_motions; ++m) {
      Vector axis{};
      axis[m % 3] = shares.weight[s] / whole;
      moved[s][m] = m < 3 ? axis : cross(axis, arm);
      for (std::size_t i = 0; i < 3; ++i)
        if (constrained_[3 * node + i] != 0) moved[s][m][i] = 0;
    }
  }
  for (std::size_t p = 0; p < n_shares; ++p)
    for (std::size_t q = 0; q < n_shares; ++q) {
      if (shares.weight[p] == 0 || shares.weight[q] == 0 || shares.cell[q] > shares.cell[p]) continue;
      auto& block = sums.at(shares.cell[p], shares.cell[q]);
      for (std::size_t m = 0; m < n_motions; ++m)
        for (std::size_t n = 0; n < n_motions; ++n)
          block[m].value[lane_of(n)] +=
              std::llrint(scale * dot(mechanics::apply(spring.stiffness, moved[p][m]), moved[q][n]));
    }
}

void CoarseSpace::find_motions(std::span<const float> residual) {
  largest_load_ = parallel::largest_magnitude(*group_, residual);
  std::ranges::fill(numbers_, CellNumbers{});
  // Non-finite values have no integer; the other part of the preconditioner propagates them.
  if (largest_load_ == 0 || !std::isfinite(largest_load_)) return;
  const double scale = std::ldexp(1.0, digits_ - std::max(std::ilogb(largest_load_), -900) - 1);

  // Forces and moments about the centre of the body; those about the cell centres follow from them.
  const auto n_cells = index(cells_.size());
  kernels_->add_loads(nodes(), residual.data(), scale, numbers_.data());
  for (std::size_t c = 0; c < n_cells; ++c)
    for (std::size_t k = 0; k < n_motions; ++k) packed_[n_motions * c + k] = numbers_[c].value[lane_of(k)];
  if (group_->size() > 1) parallel::all_reduce(*group_, packed_, MPI_SUM);
  for (std::size_t c = 0; c < n_cells; ++c) {
    double* load = &packed_[n_motions * c];
    const Vector force = (1 / (whole * scale)) * Vector{load[0], load[1], load[2]};
    const Vector moment =
        (1 / (whole * scale)) * Vector{load[3], load[4], load[5]} - cross(centre_[c], force);
    std::ranges::copy(force, load);
    std::ranges::copy(magnification_[c] * moment, load + 3);
  }
  factors_.solve(packed_);
  for (std::size_t c = 0; c < n_cells; ++c) {
    const double* motion = &packed_[n_motions * c];
    const Vector rotation = (magnification_[c] / whole) * Vector{motion[3], motion[4], motion[5]};
    const Vector translation =
        (1 / whole) * Vector{motion[0], motion[1], motion[2]} - cross(rotation, centre_[c]);
    std::ranges::copy(translation, numbers_[c].value);
    std::ranges::copy(rotation, numbers_[c].value + lane_of(3));
  }
}

double CoarseSpace::precondition(std::span<const float> residual, std::span<const std::array<float, 6>> block,
                                 std::span<float> result) {
  find_motions(residual);
  const std::int32_t bits =
      kernels_->add_motions(nodes(), residual.data(), block.data()->data(), numbers_.data(), result.data());
  return largest_load_ * static_cast<double>(std::bit_cast<float>(bits));
}

}  // namespace crackle::mechanics
