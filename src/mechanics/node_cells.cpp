// SPDX-License-Identifier: GPL-3.0-or-later
#include "node_cells.h"

#include "common/real.h"
#include "common/vector.h"
#include "parallel/agreement.h"
#include "parallel/collectives.h"
#include "parallel/ghost_exchange.h"

#include <algorithm>
#include <cmath>
#include <utility>

namespace crackle::mechanics {

namespace {

/// Cells with more nodes are halved again. Larger cells make the coarse problem cheaper and weaker.
constexpr std::int64_t nodes_per_cell = 240;
/// Larger bodies have larger cells, since the coarse matrix is replicated on every rank.
constexpr std::int64_t usual_cells = 2000;
/// Maximum number of bisections of the bounding box.
constexpr int max_depth = 20;
/// Number of times that a node takes the mean of its neighbours' shares, for cells of the usual size.
constexpr double usual_smoothings = 8;
/// Shares below one part in this number are dropped.
constexpr std::int32_t smallest_share = 20;

using Shares = NodeCells::Shares;

/// The cell of each local node, numbered along a curve through the body.
struct Division {
  std::vector<std::int32_t> cell;
  std::int32_t n_cells;
  int n_smoothings;  ///< number of smoothings that make cells of this size overlap
};
Division divide(const parallel::Communicator& group, const geometry::Subdomain& subdomain,
                const geometry::Box& box) {
  // Every box of a level has the same shape, so each level bisects the longest axis.
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
  for (const auto& node : subdomain.nodes) codes.push_back(code_of(node));
  const std::vector<std::int64_t> mine(codes.begin(), codes.begin() + subdomain.layout.n_owned);
  auto all = parallel::gather_all<std::int64_t>(group, mine);
  std::ranges::sort(all);
  const std::int64_t most = std::max(nodes_per_cell, std::ssize(all) / usual_cells);

  // Cells as ranges of codes, bisected while they contain too many nodes.
  std::vector<std::int64_t> first_code;
  const auto halve = [&](const auto& self, std::int64_t first, int level) -> void {
    const std::int64_t width = std::int64_t{1} << (max_depth - level);
    const auto begin = std::ranges::lower_bound(all, first);
    const auto end = std::ranges::lower_bound(all, first + width);
    if (begin == end) return;
    if (end - begin <= most || level == max_depth) {
      first_code.push_back(first);
      return;
    }
    self(self, first, level + 1);
    self(self, first + width / 2, level + 1);
  };
  halve(halve, 0, 0);
  const double growth = std::cbrt(static_cast<double>(most) / static_cast<double>(nodes_per_cell));
  Division division{{},
                    static_cast<std::int32_t>(first_code.size()),
                    static_cast<int>(std::lround(usual_smoothings * growth))};
  for (const auto code : codes)
    division.cell.push_back(
        static_cast<std::int32_t>(std::ranges::upper_bound(first_code, code) - first_code.begin()) - 1);
  return division;
}

/// Sums of weights by cell.
class ShareSums {
public:
  explicit ShareSums(std::int32_t n_cells) : weight_(index(n_cells)) {}

  void add(const Shares& shares) {
    for (std::size_t s = 0; s < kernels::n_shares && shares.weight[s] > 0; ++s) {
      std::int32_t& weight = weight_[index(shares.cell[s])];
      if (weight == 0) cells_.push_back(shares.cell[s]);
      weight += shares.weight[s];
    }
  }
  /// Reduces the sums to the largest ones and normalizes them; starts anew.
  Shares take();

private:
  std::vector<std::int32_t> weight_;                         // of each cell
  std::vector<std::int32_t> cells_;                          // with weight
  std::vector<std::pair<std::int32_t, std::int32_t>> sums_;  // weight and cell
};

Shares ShareSums::take() {
  auto& sums = sums_;
  sums.clear();
  for (const auto cell : cells_) sums.emplace_back(std::exchange(weight_[index(cell)], 0), cell);
  cells_.clear();
  std::int32_t total = 0;
  for (const auto& [weight, cell] : sums) total += weight;
  // The heaviest first; the lower cell if equal.
  std::ranges::sort(sums, [](const auto& a, const auto& b) {
    return a.first != b.first ? a.first > b.first : a.second < b.second;
  });
  std::size_t n_kept = 1;
  while (n_kept < std::min(sums.size(), kernels::n_shares) && smallest_share * sums[n_kept].first >= total)
    ++n_kept;
  sums.resize(n_kept);
  const std::int32_t heaviest = sums.front().second;
  std::ranges::sort(sums, {}, [](const auto& sum) { return sum.second; });
  total = 0;
  for (const auto& [weight, cell] : sums) total += weight;
  Shares shares;
  std::size_t n = 0;
  std::int32_t left = NodeCells::whole;
  for (const auto& [weight, cell] : sums) {
    const auto part = static_cast<std::int32_t>(NodeCells::whole * weight / total);
    shares.cell[n] = cell;
    shares.weight[n++] = part;
    left -= part;
  }
  for (std::size_t i = 0; i < n; ++i)
    if (shares.cell[i] == heaviest) shares.weight[i] += left;
  return shares;
}

/// The owned nodes' neighbours: first[n] to first[n + 1] of `nodes`.
struct Neighbours {
  std::vector<std::int32_t> first, nodes;
};
Neighbours neighbours_of(const geometry::Subdomain& subdomain, const Edges& edges) {
  const std::int32_t n_owned = subdomain.layout.n_owned;
  Neighbours result;
  result.first.resize(index(n_owned) + 1);
  for (const auto& ends : edges.nodes)
    for (const auto node : ends)
      if (node < n_owned) ++result.first[index(node) + 1];
  for (std::size_t n = 1; n < result.first.size(); ++n) result.first[n] += result.first[n - 1];
  result.nodes.resize(index(result.first.back()));
  auto next = result.first;
  for (const auto [a, b] : edges.nodes) {
    if (a < n_owned) result.nodes[index(next[index(a)]++)] = b;
    if (b < n_owned) result.nodes[index(next[index(b)]++)] = a;
  }
  return result;
}

}  // namespace

geometry::Box box_of_all(const parallel::Communicator& group, const geometry::Subdomain& subdomain) {
  geometry::Box box = geometry::nowhere;
  for (const auto& node : subdomain.nodes) box.include(node);
  parallel::check_peers(group);
  for (std::size_t i = 0; i < 3; ++i) {
    box.lower[i] = -parallel::largest_of_all(group, -box.lower[i]);
    box.upper[i] = parallel::largest_of_all(group, box.upper[i]);
  }
  return box;
}

NodeCells make_node_cells(const parallel::Communicator& group, const geometry::Subdomain& subdomain,
                          const Edges& edges) {
  NodeCells cells;
  cells.box = box_of_all(group, subdomain);
  const Division division = divide(group, subdomain, cells.box);
  const auto n_local = subdomain.nodes.size();
  const auto n_owned = index(subdomain.layout.n_owned);

  std::vector<double> extremes(static_cast<std::size_t>(6 * division.n_cells), -infinity);
  for (std::size_t n = 0; n < n_owned; ++n) {
    double* extreme = &extremes[6 * index(division.cell[n])];
    for (std::size_t i = 0; i < 3; ++i) {
      extreme[i] = std::max(extreme[i], -subdomain.nodes[n][i]);
      extreme[3 + i] = std::max(extreme[3 + i], subdomain.nodes[n][i]);
    }
  }
  parallel::check_peers(group);
  parallel::all_reduce(group, extremes, MPI_MAX);
  for (std::size_t c = 0; c < index(division.n_cells); ++c) {
    const double* extreme = &extremes[6 * c];
    double extent = 0;
    geometry::Point centre{};
    for (std::size_t i = 0; i < 3; ++i) {
      extent = std::max(extent, extreme[3 + i] + extreme[i]);
      centre[i] = 0.5 * (extreme[3 + i] - extreme[i]);
    }
    cells.centre.push_back(centre);
    cells.extent.push_back(extent > 0 ? extent : 1);
  }

  auto& shares = cells.shares;
  shares.resize(n_local);
  for (std::size_t n = 0; n < n_local; ++n) {
    shares[n].cell[0] = division.cell[n];
    shares[n].weight[0] = NodeCells::whole;
  }
  const Neighbours neighbours = neighbours_of(subdomain, edges);
  parallel::GhostExchange<Shares> exchange(group, subdomain.layout);
  ShareSums sums(division.n_cells);
  auto before = shares;
  for (int smoothing = 0; smoothing < division.n_smoothings; ++smoothing) {
    before = shares;
    for (std::size_t n = 0; n < n_owned; ++n) {
      sums.add(before[n]);
      for (auto i = neighbours.first[n]; i < neighbours.first[n + 1]; ++i)
        sums.add(before[index(neighbours.nodes[index(i)])]);
      shares[n] = sums.take();
    }
    parallel::check_peers(group);
    exchange.update(shares);
  }
  return cells;
}

}  // namespace crackle::mechanics
