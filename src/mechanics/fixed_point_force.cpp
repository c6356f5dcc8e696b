// SPDX-License-Identifier: GPL-3.0-or-later
#include "fixed_point_force.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdlib>
#include <functional>
#include <numeric>

namespace crackle::mechanics {

using kernels::EdgeEnds;
using kernels::EdgeSkew;
using kernels::EdgeSymmetric;
using kernels::GeneralEdges;
using kernels::NodeRecord;

namespace {

constexpr std::int32_t unplaced = std::numeric_limits<std::int32_t>::min();

/// Assigns each edge to one of its nodes such that nearly all nodes own a multiple of four: a node keeps as
/// many edges to later nodes as that allows and leaves the rest to them.
/// @return the edges of each owned node
template <class IsChosen>
std::vector<std::vector<std::int32_t>> owned_edges(const Edges& edges, std::int32_t n_owned,
                                                   const IsChosen& is_chosen) {
  std::vector<std::vector<std::int32_t>> of_node(index(n_owned));
  for (std::size_t begin = 0; begin < edges.size();) {
    const std::int32_t node = edges.nodes[begin][0];
    std::vector<std::int32_t> candidates;
    std::size_t end = begin;
    for (; end < edges.size() && edges.nodes[end][0] == node; ++end)
      if (is_chosen(static_cast<std::int32_t>(end))) candidates.push_back(static_cast<std::int32_t>(end));
    begin = end;
    auto& mine = of_node[index(node)];
    // Ghosts own no edges, so edges to ghosts are kept.
    const auto is_kept = [&](std::int32_t edge) { return edges.nodes[index(edge)][1] >= n_owned; };
    std::stable_partition(candidates.begin(), candidates.end(), is_kept);
    const auto n_kept = static_cast<std::size_t>(std::ranges::count_if(candidates, is_kept));
    std::size_t n_take = candidates.size();
    while (n_take > n_kept && (mine.size() + n_take) % 4 != 0) --n_take;
    if ((mine.size() + n_take) % 4 != 0) n_take = candidates.size();
    mine.insert(mine.end(), candidates.begin(), candidates.begin() + static_cast<std::ptrdiff_t>(n_take));
    for (std::size_t i = n_take; i < candidates.size(); ++i)
      of_node[index(edges.nodes[index(candidates[i])][1])].push_back(candidates[i]);
  }
  return of_node;
}

}  // namespace

template <class Real>
FixedPointForce<Real>::FixedPointForce(const geometry::Subdomain& subdomain, const PdsOperators& operators,
                                       const ElasticityField& elasticity, const Edges& edges,
                                       const ResidualStiffness& residual_stiffness,
                                       std::span<const double> inverse_mass, const FixedPointScale& scale,
                                       InstructionSet instruction_set, bool watches, std::int32_t pair_reach)
    : subdomain_(&subdomain),
      operators_(operators.tetrahedra),
      elasticity_(&elasticity),
      edges_(&edges),
      residual_stiffness_(&residual_stiffness),
      scale_(scale),
      kernels_(&kernels::kernels<Real>(instruction_set, watches)),
      nodes_(subdomain.nodes.size(), NodeRecord<Real>{}),
      blocks_((index(subdomain.layout.n_owned) + nodes_per_block - 1) / nodes_per_block),
      block_number_(blocks_.size()),
      place_(edges.size(), unplaced) {
  for (std::size_t i = 0; i < inverse_mass.size(); ++i)
    nodes_[i].inverse_mass = static_cast<Real>(inverse_mass[i]);
  number_blocks();
  const auto is_whole = [&](std::int32_t edge) {
    const auto is_intact = [&](std::int32_t t) { return residual_stiffness.is_intact(t); };
    return edges.is_symmetric(edge, elasticity) && std::ranges::all_of(edges.round(edge), is_intact);
  };
  const auto fits_pair = [&](std::int32_t edge) {
    const auto [a, b] = edges.nodes[index(edge)];
    return std::abs(a - b) <= pair_reach;
  };
  const auto whole = owned_edges(edges, subdomain.layout.n_owned,
                                 [&](std::int32_t edge) { return fits_pair(edge) && is_whole(edge); });
  const auto other = owned_edges(edges, subdomain.layout.n_owned,
                                 [&](std::int32_t edge) { return fits_pair(edge) && !is_whole(edge); });
  for (std::int32_t b = 0; b < n_blocks(); ++b) {
    Block& block = blocks_[index(b)];
    block.first_pair = ends_.size();
    lay_out_pairs(b, whole);
    block.first_skew_pair = ends_.size();
    block.first_skew = skew_.size();
    lay_out_pairs(b, other);
    block.last_pair = ends_.size();
    skew_.resize(skew_.size() + block.last_pair - block.first_skew_pair, EdgeSkew<Real>{});
  }
  ends_.shrink_to_fit();
  symmetric_.resize(ends_.size(), EdgeSymmetric<Real>{});
  for (std::size_t e = 0; e < edges.size(); ++e) {
    const auto edge = static_cast<std::int32_t>(e);
    if (place_[e] == unplaced) append_general(edge, block_of(edges.nodes[e][0]));
    set_coefficients(edge, scaled(edge_coupling(operators_, elasticity, edges, residual_stiffness, edge)));
  }
  find_reach();
}

template <class Real>
void FixedPointForce<Real>::number_blocks() {
  std::vector<std::vector<std::int32_t>> neighbours(blocks_.size());
  std::vector<std::int32_t> distance(blocks_.size(), std::numeric_limits<std::int32_t>::max());
  std::vector<std::int32_t> reached;
  for (const auto [first, second] : edges_->nodes) {
    const std::int32_t block = first / nodes_per_block;
    if (second < subdomain_->layout.n_owned) {
      const std::int32_t other = second / nodes_per_block;
      if (block == other) continue;
      neighbours[index(block)].push_back(other);
      neighbours[index(other)].push_back(block);
    } else if (std::exchange(distance[index(block)], 0) != 0) {
      reached.push_back(block);
    }
  }
  for (std::size_t i = 0; i < reached.size(); ++i) {
    const std::int32_t next = distance[index(reached[i])] + 1;
    for (const auto neighbour : neighbours[index(reached[i])]) {
      if (distance[index(neighbour)] <= next) continue;
      distance[index(neighbour)] = next;
      reached.push_back(neighbour);
    }
  }
  std::vector<std::int32_t> order(blocks_.size());
  std::iota(order.begin(), order.end(), 0);
  std::ranges::stable_sort(order, std::greater{}, [&](std::int32_t block) { return distance[index(block)]; });
  for (std::int32_t b = 0; b < n_blocks(); ++b) {
    blocks_[index(b)].first_node = order[index(b)] * nodes_per_block;
    block_number_[index(order[index(b)])] = b;
  }
}

template <class Real>
void FixedPointForce<Real>::lay_out_pairs(std::int32_t block,
                                          std::span<const std::vector<std::int32_t>> owned_edges) {
  std::size_t lane = 0;  // lane of the open pair; 0 if there is none
  const auto put = [&](std::int32_t node) {
    ends_.back().target[lane++] = static_cast<std::int16_t>(node - ends_.back().owner);
  };
  std::int32_t owner = first_node(block);
  for (const std::int32_t last = std::min(owner + nodes_per_block, subdomain_->layout.n_owned); owner < last;
       ++owner) {
    const auto& edges = owned_edges[index(owner)];
    for (std::size_t i = 0; i < edges.size(); ++i) {
      if (lane == 0) ends_.push_back({owner, 0, {}});
      if (lane == 4) ends_.back().second_owner = static_cast<std::int16_t>(owner - ends_.back().owner);
      const auto [a, other] = edges_->nodes[index(edges[i])];
      place_[index(edges[i])] = static_cast<std::int32_t>(8 * (ends_.size() - 1) + lane);
      put(a == owner ? other : a);
      while (i + 1 == edges.size() && lane % 4 != 0) put(owner);
      lane %= 8;
    }
  }
  while (lane != 0 && lane < 8) put(ends_.back().owner);
}

template <class Real>
void FixedPointForce<Real>::append_general(std::int32_t edge, std::int32_t number) {
  Block& block = blocks_[index(number)];
  const auto lane = index(block.n_general % 8);
  if (lane == 0) {
    // Free slots are filled with edges from a node to itself.
    auto& fresh = block.general.emplace_back();
    std::ranges::fill(fresh.first, edges_->nodes[index(edge)][0]);
    std::ranges::fill(fresh.second, edges_->nodes[index(edge)][0]);
  }
  block.general.back().first[lane] = edges_->nodes[index(edge)][0];
  block.general.back().second[lane] = edges_->nodes[index(edge)][1];
  place_[index(edge)] = -1 - static_cast<std::int32_t>(general_places_.size());
  general_places_.push_back({number, block.n_general++});
}

template <class Real>
std::int32_t FixedPointForce<Real>::block_of_edge(std::int32_t edge) const {
  if (is_general(edge)) return general_place(edge).block;
  return block_of(ends_[index(place_[index(edge)] / 8)].owner);
}

template <class Real>
auto FixedPointForce<Real>::scaled(const EdgeCoupling& coupling) const -> Coefficients {
  const double factor = scale_.displacement / scale_.force;
  Coefficients values{};
  for (std::size_t i = 0; i < 6; ++i) values[i] = static_cast<Real>(coupling.s[i] * factor);
  for (std::size_t i = 0; i < 3; ++i) values[6 + i] = static_cast<Real>(coupling.w[i] * factor);
  return values;
}

template <class Real>
auto FixedPointForce<Real>::pair_place(std::int32_t edge) -> PairPlace {
  const Block& block = blocks_[index(block_of_edge(edge))];
  const auto pair = index(place_[index(edge)] / 8);
  const auto lane = index(place_[index(edge)] % 8);
  const EdgeEnds& ends = ends_[pair];
  const std::int32_t owner = ends.owner + (lane < 4 ? 0 : ends.second_owner);
  const bool has_skew = pair >= block.first_skew_pair;
  return {&symmetric_[pair], has_skew ? &skew_[block.first_skew + pair - block.first_skew_pair] : nullptr,
          lane, owner == edges_->nodes[index(edge)][0] ? Real(1) : Real(-1)};
}

template <class Real>
auto FixedPointForce<Real>::coefficients(std::int32_t edge) -> Coefficients {
  Coefficients values{};
  if (is_general(edge)) {
    const auto [block, number] = general_place(edge);
    const auto& group = blocks_[index(block)].general[index(number / 8)];
    for (std::size_t i = 0; i < 6; ++i) values[i] = group.s[i][number % 8];
    for (std::size_t i = 0; i < 3; ++i) values[6 + i] = group.w[i][number % 8];
  } else {
    const PairPlace at = pair_place(edge);
    for (std::size_t i = 0; i < 6; ++i) values[i] = at.symmetric->s[i][at.lane];
    for (std::size_t i = 0; i < 3 && at.skew != nullptr; ++i)
      values[6 + i] = at.direction * at.skew->w[i][at.lane];
  }
  return values;
}

template <class Real>
void FixedPointForce<Real>::set_coefficients(std::int32_t edge, const Coefficients& values) {
  const bool joins = !ends_part_ || values != Coefficients{};
  const auto [a, b] = edges_->nodes[index(edge)];
  if (is_general(edge)) {
    const auto [block, number] = general_place(edge);
    auto& group = blocks_[index(block)].general[index(number / 8)];
    group.second[number % 8] = joins ? b : a;
    for (std::size_t i = 0; i < 6; ++i) group.s[i][number % 8] = values[i];
    for (std::size_t i = 0; i < 3; ++i) group.w[i][number % 8] = values[6 + i];
  } else {
    const PairPlace at = pair_place(edge);
    EdgeEnds& ends = ends_[index(place_[index(edge)] / 8)];
    const auto [owner, other] = at.direction > 0 ? std::pair(a, b) : std::pair(b, a);
    ends.target[at.lane] = static_cast<std::int16_t>((joins ? other : owner) - ends.owner);
    for (std::size_t i = 0; i < 6; ++i) at.symmetric->s[i][at.lane] = values[i];
    for (std::size_t i = 0; i < 3 && at.skew != nullptr; ++i)
      at.skew->w[i][at.lane] = at.direction * values[6 + i];
  }
}

template <class Real>
void FixedPointForce<Real>::let_ends_part() {
  ends_part_ = true;
  for (std::size_t e = 0; e < edges_->size(); ++e) {
    const auto edge = static_cast<std::int32_t>(e);
    set_coefficients(edge, coefficients(edge));
  }
}

template <class Real>
void FixedPointForce<Real>::find_reach() {
  for (std::int32_t b = 0; b < n_blocks(); ++b) {
    blocks_[index(b)].reach = {b, false};
    blocks_[index(b)].last_contributor = b;
  }
  for (std::size_t e = 0; e < edges_->size(); ++e) {
    const std::int32_t toucher = block_of_edge(static_cast<std::int32_t>(e));
    auto& reach = blocks_[index(toucher)].reach;
    for (const std::int32_t node : edges_->nodes[e]) {
      if (node >= subdomain_->layout.n_owned) {
        reach.has_ghosts = true;
        continue;
      }
      const std::int32_t touched = block_of(node);
      reach.last_owned = std::max(reach.last_owned, touched);
      auto& last = blocks_[index(touched)].last_contributor;
      last = std::max(last, toucher);
    }
  }
}

template <class Real>
void FixedPointForce<Real>::add_block(std::int32_t number) {
  const Block& block = blocks_[index(number)];
  see(kernels_->add_symmetric_edges(ends_.data() + block.first_pair, symmetric_.data() + block.first_pair,
                                    block.first_skew_pair - block.first_pair, nodes_.data()));
  see(kernels_->add_skew_edges(ends_.data() + block.first_skew_pair,
                               symmetric_.data() + block.first_skew_pair, skew_.data() + block.first_skew,
                               block.last_pair - block.first_skew_pair, nodes_.data()));
  see(kernels_->add_general_edges(block.general.data(), block.general.size(), nodes_.data()));
}

template <class Real>
void FixedPointForce<Real>::evaluate() {
  const auto clear = [&](std::int32_t first, std::int32_t last) {
    for (auto& node : std::span(nodes_).subspan(index(first), index(last - first)))
      std::ranges::fill(node.force, Integer(0));
  };
  const auto n_local = static_cast<std::int32_t>(nodes_.size());
  clear(subdomain_->layout.n_owned, n_local);
  // A block is cleared just before it is first touched, when its nodes are needed in cache anyway.
  std::int32_t n_clear = 0;
  for (std::int32_t b = 0; b < n_blocks(); ++b) {
    for (; n_clear <= reach(b).last_owned; ++n_clear)
      clear(first_node(n_clear), std::min(first_node(n_clear) + nodes_per_block, subdomain_->layout.n_owned));
    add_block(b);
  }
}

template <class Real>
void FixedPointForce<Real>::update(std::span<const std::int32_t> tetrahedra, bool force_is_current) {
  std::vector<std::int32_t> changed;
  for (const auto t : tetrahedra)
    for (const auto edge : edges_->of_tetrahedron(subdomain_->tetrahedra[index(t)]))
      if (edge >= 0) changed.push_back(edge);
  std::ranges::sort(changed);
  changed.erase(std::unique(changed.begin(), changed.end()), changed.end());

  const auto hand_on = [&](Real sign) {
    if (!force_is_current) return;
    for (std::size_t begin = 0; begin < changed.size(); begin += 8) {
      GeneralEdges<Real> group{};
      for (std::size_t lane = 0; lane < 8; ++lane) {
        const auto edge = changed[std::min(begin + lane, changed.size() - 1)];
        const Coefficients values = coefficients(edge);
        group.first[lane] = edges_->nodes[index(edge)][0];
        group.second[lane] = edges_->nodes[index(edge)][ends_part_ && values == Coefficients{} ? 0 : 1];
        if (begin + lane >= changed.size()) continue;
        for (std::size_t i = 0; i < 6; ++i) group.s[i][lane] = sign * values[i];
        for (std::size_t i = 0; i < 3; ++i) group.w[i][lane] = sign * values[6 + i];
      }
      see(kernels_->add_general_edges(&group, 1, nodes_.data()));
    }
  };
  hand_on(-1);
  for (const auto edge : changed) {
    if (!is_general(edge) && pair_place(edge).skew == nullptr) {
      set_coefficients(edge, {});
      append_general(edge, block_of_edge(edge));
    }
    set_coefficients(edge,
                     scaled(edge_coupling(operators_, *elasticity_, *edges_, *residual_stiffness_, edge)));
  }
  hand_on(1);
}

template <class Real>
std::int64_t FixedPointForce<Real>::bytes_per_sweep() const {
  std::size_t bytes = ends_.size() * (sizeof(EdgeEnds) + sizeof(EdgeSymmetric<Real>)) +
                      skew_.size() * sizeof(EdgeSkew<Real>) + 2 * nodes_.size() * sizeof(NodeRecord<Real>);
  for (const Block& block : blocks_) bytes += block.general.size() * sizeof(GeneralEdges<Real>);
  return static_cast<std::int64_t>(bytes);
}

template <class Real>
double FixedPointForce<Real>::padding() const {
  const auto n_edges =
      static_cast<double>(std::ranges::count_if(place_, [](auto place) { return place >= 0; }));
  return n_edges > 0 ? 8 * static_cast<double>(ends_.size()) / n_edges - 1 : 0;
}

template <class Real>
template <class Visit>
void FixedPointForce<Real>::for_each_stretch(const Visit& visit) const {
  // The magnitude, which is equal for both directions of an edge: ranks may use different ones.
  const auto visit_edge = [&](std::int32_t a, std::int32_t b, const auto& s, std::size_t lane) {
    std::array<double, 3> d{};
    for (std::size_t i = 0; i < 3; ++i)
      d[i] = static_cast<double>(
          kernels::difference(nodes_[index(b)].displacement[i], nodes_[index(a)].displacement[i]));
    const auto force = [&](std::size_t x, std::size_t y, std::size_t z) {
      return static_cast<double>(s[x][lane]) * d[0] + static_cast<double>(s[y][lane]) * d[1] +
             static_cast<double>(s[z][lane]) * d[2];
    };
    const auto largest = [](double x, double y, double z) {
      return std::max({std::abs(x), std::abs(y), std::abs(z)});
    };
    // S as xx, yy, zz, yz, xz, xy.
    visit(a, b, largest(d[0], d[1], d[2]), largest(force(0, 5, 4), force(5, 1, 3), force(4, 3, 2)));
  };
  const auto carries = [](const auto& s, std::size_t lane) {
    return s[0][lane] != 0 || s[1][lane] != 0 || s[2][lane] != 0;
  };
  for (std::size_t pair = 0; pair < ends_.size(); ++pair) {
    const EdgeEnds& ends = ends_[pair];
    const auto& s = symmetric_[pair].s;
    for (std::size_t lane = 0; lane < 8; ++lane)
      if (carries(s, lane))
        visit_edge(ends.owner + (lane < 4 ? 0 : ends.second_owner), ends.owner + ends.target[lane], s, lane);
  }
  for (const Block& block : blocks_)
    for (const auto& group : block.general)
      for (std::size_t lane = 0; lane < 8; ++lane)
        if (carries(group.s, lane)) visit_edge(group.first[lane], group.second[lane], group.s, lane);
}

template <class Real>
double FixedPointForce<Real>::largest_stretch() const {
  double largest = 0;
  for_each_stretch(
      [&](std::int32_t, std::int32_t, double stretch, double) { largest = std::max(largest, stretch); });
  return largest;
}

template <class Real>
void FixedPointForce<Real>::add_overstretched(double least, std::vector<std::int32_t>& nodes) const {
  for_each_stretch([&](std::int32_t a, std::int32_t b, double stretch, double force) {
    if (stretch >= least || force >= contribution_limit / 4) nodes.insert(nodes.end(), {a, b});
  });
}

template class FixedPointForce<float>;
template class FixedPointForce<double>;

}  // namespace crackle::mechanics
