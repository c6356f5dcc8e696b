// SPDX-License-Identifier: GPL-3.0-or-later
#include "coarse_space.h"

#include "crackle/common/index.h"
#include "crackle/common/real.h"
#include "crackle/parallel/collectives.h"

#include <Eigen/SparseCholesky>
#include <Eigen/SparseCore>

#include <algorithm>
#include <cmath>
#include <map>
#include <stdexcept>

namespace crackle::mechanics {

namespace {

/// More nodes make a cell to be halved again. Larger cells make the coarse problem cheaper and weaker.
constexpr std::int64_t max_nodes_per_cell = 160;
/// Halvings of the bounding box at most.
constexpr int max_depth = 20;
constexpr int n_motions = 6;
/// Stiffness added to every coarse unknown, over the largest entry: cells whose nodes lie on a line, or have
/// come loose, leave the matrix singular.
constexpr double regularization = 1e-10;
/// Digits of the integers that are summed, below the largest term: thousands of terms fit 64 bits.
constexpr int digits = 44;

}  // namespace

struct CoarseSpace::Factors {
  Eigen::SimplicialLDLT<Eigen::SparseMatrix<double>> solver;
  // For add_correction(), which must not allocate: ranks wait for each other in it.
  std::vector<std::int64_t> sums;
  Eigen::VectorXd sides, motion, inverse_diagonal;

  void make_room(std::size_t n) {
    sums.resize(n);
    sides.resize(static_cast<Eigen::Index>(n));
    motion.resize(static_cast<Eigen::Index>(n));
  }

  /// As solver.solve(), from `sides` to `motion`.
  void solve() {
    motion.noalias() = solver.permutationP() * sides;
    solver.matrixL().solveInPlace(motion);
    sides.noalias() = inverse_diagonal.cwiseProduct(motion);
    solver.matrixU().solveInPlace(sides);
    motion.noalias() = solver.permutationPinv() * sides;
  }
};

CoarseSpace::CoarseSpace(const parallel::Communicator& group, const geometry::Subdomain& subdomain,
                         std::span<const std::uint8_t> held)
    : group_(&group), subdomain_(&subdomain), held_(held), factors_(std::make_unique<Factors>()) {
  find_cells();
}

CoarseSpace::~CoarseSpace() = default;

void CoarseSpace::find_cells() {
  geometry::Box box = geometry::nowhere;
  for (const auto& node : subdomain_->nodes) box.include(node);
  parallel::agree(*group_);
  for (std::size_t i = 0; i < 3; ++i) {
    box.lower[i] = -parallel::largest_of_all(*group_, -box.lower[i]);
    box.upper[i] = parallel::largest_of_all(*group_, box.upper[i]);
  }

  // Every box of a level has the same shape, so each level halves one axis: the longest.
  Vector side = box.upper - box.lower;
  std::array<int, 3> halvings{};
  std::array<std::size_t, max_depth> axis_of_level{};
  for (auto& axis : axis_of_level) {
    axis = static_cast<std::size_t>(std::ranges::max_element(side) - side.begin());
    side[axis] /= 2;
    ++halvings[axis];
  }
  const auto code_of = [&](const geometry::Point& p) {
    std::array<std::int64_t, 3> place{};
    for (std::size_t i = 0; i < 3; ++i) {
      const double extent = box.upper[i] - box.lower[i];
      const std::int64_t n = std::int64_t{1} << halvings[i];
      const double x = extent > 0 ? (p[i] - box.lower[i]) / extent : 0;
      place[i] = std::min(n - 1, static_cast<std::int64_t>(x * static_cast<double>(n)));
    }
    std::int64_t code = 0;
    auto left = halvings;
    for (const auto axis : axis_of_level) code = 2 * code + ((place[axis] >> --left[axis]) & 1);
    return code;
  };

  std::vector<std::int64_t> codes;
  for (const auto& node : subdomain_->nodes) codes.push_back(code_of(node));
  const std::vector<std::int64_t> mine(codes.begin(), codes.begin() + subdomain_->layout.n_owned);
  auto all = parallel::gather_all<std::int64_t>(*group_, mine);
  std::ranges::sort(all);

  // Cells as ranges of codes: halved while they hold too many nodes.
  std::vector<std::int64_t> first_code;
  const auto divide = [&](const auto& self, std::int64_t first, int level) -> void {
    const std::int64_t width = std::int64_t{1} << (max_depth - level);
    const auto begin = std::ranges::lower_bound(all, first);
    const auto end = std::ranges::lower_bound(all, first + width);
    if (begin == end) return;
    if (end - begin <= max_nodes_per_cell || level == max_depth) {
      first_code.push_back(first);
      return;
    }
    self(self, first, level + 1);
    self(self, first + width / 2, level + 1);
  };
  divide(divide, 0, 0);
  n_cells_ = static_cast<std::int32_t>(first_code.size());

  // Arms are taken about the middle of a box that the cell's first code lies in: any point will do.
  cell_.resize(codes.size());
  for (std::size_t n = 0; n < codes.size(); ++n)
    cell_[n] =
        static_cast<std::int32_t>(std::ranges::upper_bound(first_code, codes[n]) - first_code.begin()) - 1;
  std::vector<double> extremes(static_cast<std::size_t>(6 * n_cells_), -infinity);
  for (std::size_t n = 0; n < static_cast<std::size_t>(subdomain_->layout.n_owned); ++n) {
    double* extreme = &extremes[6 * index(cell_[n])];
    for (std::size_t i = 0; i < 3; ++i) {
      extreme[i] = std::max(extreme[i], -subdomain_->nodes[n][i]);
      extreme[3 + i] = std::max(extreme[3 + i], subdomain_->nodes[n][i]);
    }
  }
  factors_->make_room(extremes.size());
  parallel::agree(*group_);
  parallel::all_reduce(*group_, extremes, MPI_MAX);
  arm_.resize(codes.size());
  for (std::size_t n = 0; n < codes.size(); ++n) {
    const double* extreme = &extremes[6 * index(cell_[n])];
    double size = 0;
    for (std::size_t i = 0; i < 3; ++i) size = std::max(size, extreme[3 + i] + extreme[i]);
    for (std::size_t i = 0; i < 3; ++i)
      arm_[n][i] = size > 0 ? (subdomain_->nodes[n][i] - 0.5 * (extreme[3 + i] - extreme[i])) / size : 0;
  }
}

double CoarseSpace::rigid(std::size_t n, std::size_t i, std::size_t motion) const {
  if (held_[3 * n + i] != 0) return 0;
  if (motion < 3) return i == motion ? 1 : 0;
  // Rotation about axis m: e_m x arm.
  const std::size_t m = motion - 3;
  if (i == (m + 1) % 3) return -arm_[n][(m + 2) % 3];
  if (i == (m + 2) % 3) return arm_[n][(m + 1) % 3];
  return 0;
}

void CoarseSpace::factorize(const PdsOperators& operators, const IsotropicElasticity& elasticity,
                            const ResidualStiffness& residual_stiffness) {
  // A tetrahedron's coarse entries are below its stiffness bound times the motions, which are below 1.
  const auto stiffness_bound = [&](const TetrahedronOperator& t) {
    double steepest = 0;
    for (const auto& g : t.gradient) steepest = std::max(steepest, dot(g, g));
    return t.volume * (std::abs(elasticity.lambda) + 2 * elasticity.mu) * steepest;
  };
  double stiffest = 0;
  for (const auto& t : operators.tetrahedra) stiffest = std::max(stiffest, stiffness_bound(t));
  parallel::agree(*group_);
  stiffest = parallel::largest_of_all(*group_, stiffest);
  const double scale = std::ldexp(1.0, digits - std::ilogb(stiffest) - 8);

  using Block = std::array<std::int64_t, n_motions * n_motions>;
  std::map<std::pair<std::int32_t, std::int32_t>, Block> blocks;
  for (std::size_t number = 0; number < operators.tetrahedra.size(); ++number) {
    const auto tetrahedron = static_cast<std::int32_t>(number);
    if (!residual_stiffness.carries(tetrahedron) || subdomain_->counted[number] == 0) continue;
    const auto& t = operators.tetrahedra[number];
    // Strains of the four corners' rigid motions; energy products between them.
    std::array<std::array<Symmetric, n_motions>, 4> strains{};
    for (std::size_t a = 0; a < 4; ++a) {
      const auto node = static_cast<std::size_t>(t.nodes[a]);
      const Vector& b = t.gradient[a];
      for (std::size_t m = 0; m < n_motions; ++m) {
        const Vector u{rigid(node, 0, m), rigid(node, 1, m), rigid(node, 2, m)};
        strains[a][m] = symmetric_product(u, b);
      }
    }
    // Corners in the same cell move together.
    std::array<std::int32_t, 4> cells{};
    std::array<std::array<Symmetric, n_motions>, 4> of_cell{};
    std::size_t n_here = 0;
    for (std::size_t a = 0; a < 4; ++a) {
      const std::int32_t cell = cell_[index(t.nodes[a])];
      const auto place = static_cast<std::size_t>(
          std::find(cells.begin(), cells.begin() + static_cast<std::ptrdiff_t>(n_here), cell) -
          cells.begin());
      if (place == n_here) cells[n_here++] = cell;
      for (std::size_t m = 0; m < n_motions; ++m)
        for (std::size_t k = 0; k < 6; ++k) of_cell[place][m][k] += strains[a][m][k];
    }
    for (std::size_t p = 0; p < n_here; ++p) {
      for (std::size_t q = 0; q < n_here; ++q) {
        if (cells[q] > cells[p]) continue;
        Block& block = blocks[{cells[p], cells[q]}];
        for (std::size_t m = 0; m < n_motions; ++m) {
          const Symmetric sigma = residual_stiffness.stress(tetrahedron, of_cell[p][m]);
          for (std::size_t n = 0; n < n_motions; ++n)
            block[n_motions * m + n] += std::llrint(scale * (t.volume * contract(sigma, of_cell[q][n])));
        }
      }
    }
  }

  std::vector<std::int64_t> packed;
  for (const auto& [cells, block] : blocks) {
    packed.push_back(cells.first);
    packed.push_back(cells.second);
    packed.insert(packed.end(), block.begin(), block.end());
  }
  const auto all = group_->size() > 1 ? parallel::gather_all<std::int64_t>(*group_, packed) : packed;
  blocks.clear();
  constexpr std::size_t stride = 2 + n_motions * n_motions;
  for (std::size_t at = 0; at < all.size(); at += stride) {
    Block& block = blocks[{static_cast<std::int32_t>(all[at]), static_cast<std::int32_t>(all[at + 1])}];
    for (std::size_t k = 0; k < block.size(); ++k) block[k] += all[at + 2 + k];
  }

  const Eigen::Index size = static_cast<Eigen::Index>(n_motions) * n_cells_;
  std::vector<Eigen::Triplet<double>> entries;
  double largest_entry = 0;
  for (const auto& [cells, block] : blocks) {
    for (int m = 0; m < n_motions; ++m) {
      for (int n = 0; n < n_motions; ++n) {
        const int row = n_motions * cells.first + m, column = n_motions * cells.second + n;
        if (column > row) continue;
        const double value = static_cast<double>(block[index(n_motions * m + n)]) / scale;
        entries.emplace_back(row, column, value);
        largest_entry = std::max(largest_entry, std::abs(value));
      }
    }
  }
  for (int i = 0; i < size; ++i) entries.emplace_back(i, i, regularization * largest_entry);
  Eigen::SparseMatrix<double> matrix(size, size);
  matrix.setFromTriplets(entries.begin(), entries.end());
  factors_->solver.compute(matrix);
  if (factors_->solver.info() != Eigen::Success)
    throw std::runtime_error("static solver: the coarse matrix could not be factorized");
  factors_->inverse_diagonal = factors_->solver.vectorD().cwiseInverse();
}

void CoarseSpace::add_correction(std::span<const double> residual, std::span<double> correction) const {
  double largest = 0;
  for (const double r : residual)
    if (!(std::abs(r) <= largest)) largest = std::isnan(r) ? infinity : std::abs(r);
  largest = parallel::largest_of_all(*group_, largest);
  // What is not finite has no integer; the caller's other part of the preconditioner hands it on.
  if (largest == 0 || !std::isfinite(largest)) return;
  const double scale = std::ldexp(1.0, digits - std::ilogb(largest) - 1);
  auto& sums = factors_->sums;
  std::ranges::fill(sums, 0);
  for (std::size_t n = 0; n < residual.size() / 3; ++n) {
    std::int64_t* sum = &sums[n_motions * static_cast<std::size_t>(cell_[n])];
    const std::array<double, 3>& arm = arm_[n];
    std::array<double, 3> r{};
    for (std::size_t i = 0; i < 3; ++i) r[i] = held_[3 * n + i] != 0 ? 0 : scale * residual[3 * n + i];
    for (std::size_t i = 0; i < 3; ++i) {
      sum[i] += std::llrint(r[i]);
      sum[3 + i] += std::llrint(arm[(i + 1) % 3] * r[(i + 2) % 3] - arm[(i + 2) % 3] * r[(i + 1) % 3]);
    }
  }
  if (group_->size() > 1) parallel::all_reduce(*group_, sums, MPI_SUM);
  for (std::size_t i = 0; i < sums.size(); ++i)
    factors_->sides[static_cast<Eigen::Index>(i)] = static_cast<double>(sums[i]) / scale;
  factors_->solve();
  for (std::size_t n = 0; n < residual.size() / 3; ++n) {
    const double* c = &factors_->motion[n_motions * cell_[n]];
    const std::array<double, 3>& arm = arm_[n];
    for (std::size_t i = 0; i < 3; ++i) {
      if (held_[3 * n + i] != 0) continue;
      correction[3 * n + i] +=
          c[i] + (c[3 + (i + 1) % 3] * arm[(i + 2) % 3] - c[3 + (i + 2) % 3] * arm[(i + 1) % 3]);
    }
  }
}

}  // namespace crackle::mechanics
