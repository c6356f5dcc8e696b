// SPDX-License-Identifier: GPL-3.0-or-later
#include "fixed_point_force.h"

#include <algorithm>
#include <cmath>

namespace crackle::mechanics {

using kernels::EdgeEnds;
using kernels::EdgeStiffness;
using kernels::GeneralEdges;
using kernels::NodeRecord;

namespace {

constexpr std::size_t index(std::int32_t i) {
  return static_cast<std::size_t>(i);
}

/// Gives each edge to one of its nodes so that nearly all nodes own a multiple of four: a node keeps as many
/// of the edges to later nodes as that allows and leaves the rest to them.
/// @param plain 1 for the edges to distribute
/// @return the edges of each owned node
std::vector<std::vector<std::int32_t>> owned_edges(const Edges& edges, std::span<const std::uint8_t> plain,
                                                   std::int32_t n_owned) {
  std::vector<std::vector<std::int32_t>> of_node(index(n_owned));
  for (std::size_t begin = 0; begin < edges.size();) {
    const std::int32_t node = edges.nodes[begin][0];
    std::vector<std::int32_t> candidates;
    std::size_t end = begin;
    for (; end < edges.size() && edges.nodes[end][0] == node; ++end)
      if (plain[end] != 0) candidates.push_back(static_cast<std::int32_t>(end));
    begin = end;
    auto& mine = of_node[index(node)];
    // Ghosts own nothing: their edges are kept.
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
                                       const IsotropicElasticity& elasticity, const Edges& edges,
                                       const Integrity& integrity, std::span<const double> inverse_mass,
                                       const FixedPointScale& scale, InstructionSet instruction_set)
    : subdomain_(&subdomain),
      operators_(&operators),
      elasticity_(&elasticity),
      edges_(&edges),
      integrity_(&integrity),
      scale_(scale),
      kernels_(&kernels::kernels<Real>(instruction_set)),
      nodes_(subdomain.nodes.size(), NodeRecord<Real>{}),
      blocks_((index(subdomain.n_owned) + nodes_per_block - 1) / nodes_per_block),
      block_of_edge_(edges.size(), 0),
      plain_place_(edges.size(), -1),
      general_place_(edges.size(), -1) {
  for (std::size_t i = 0; i < inverse_mass.size(); ++i)
    nodes_[i].inverse_mass = static_cast<Real>(inverse_mass[i]);
  std::vector<std::uint8_t> plain(edges.size());
  for (std::size_t e = 0; e < edges.size(); ++e) {
    const auto is_intact = [&](std::int32_t t) { return integrity.is_intact(t); };
    plain[e] =
        edges.is_inner[e] != 0 && std::ranges::all_of(edges.round(static_cast<std::int32_t>(e)), is_intact);
  }
  lay_out_plain(owned_edges(edges, plain, subdomain.n_owned));
  for (std::size_t e = 0; e < edges.size(); ++e) {
    const auto edge = static_cast<std::int32_t>(e);
    if (plain[e] == 0) {
      block_of_edge_[e] = edges.nodes[e][0] / nodes_per_block;
      append_general(edge);
    }
    set_coefficients(edge, scaled(edge_coupling(operators, elasticity, edges, integrity, edge)));
  }
  find_reach();
}

template <class Real>
void FixedPointForce<Real>::lay_out_plain(const std::vector<std::vector<std::int32_t>>& owned_edges) {
  std::size_t lane = 0;  // of the open pair; 0 when there is none
  const auto pad = [&](std::int32_t owner, std::size_t until) {
    for (; lane < until; ++lane) ends_.back().target[lane] = owner;
  };
  for (std::int32_t b = 0; b < n_blocks(); ++b) {
    Block& block = blocks_[index(b)];
    block.first_pair = ends_.size();
    std::int32_t owner = b * nodes_per_block;
    for (const std::int32_t last = std::min(owner + nodes_per_block, subdomain_->n_owned); owner < last;
         ++owner) {
      const auto& edges = owned_edges[index(owner)];
      for (std::size_t i = 0; i < edges.size(); ++i) {
        if (i % 4 == 0) {
          if (lane == 0) {
            ends_.emplace_back();
            stiffness_.emplace_back();
          }
          ends_.back().owner[lane / 4] = owner;
        }
        const auto [a, other] = edges_->nodes[index(edges[i])];
        ends_.back().target[lane] = a == owner ? other : a;
        plain_place_[index(edges[i])] = static_cast<std::int32_t>(8 * (ends_.size() - 1) + lane);
        block_of_edge_[index(edges[i])] = b;
        ++lane;
        if (i + 1 == edges.size()) pad(owner, lane <= 4 ? 4 : 8);
        lane %= 8;
      }
    }
    if (lane != 0) {
      ends_.back().owner[1] = ends_.back().owner[0];
      pad(ends_.back().owner[0], 8);
      lane = 0;
    }
    block.last_pair = ends_.size();
  }
}

template <class Real>
void FixedPointForce<Real>::append_general(std::int32_t edge) {
  Block& block = blocks_[index(block_of_edge_[index(edge)])];
  const auto lane = index(block.n_general % 8);
  if (lane == 0) {
    // Free places are edges of a node with itself.
    auto& fresh = block.general.emplace_back();
    std::ranges::fill(fresh.first, edges_->nodes[index(edge)][0]);
    std::ranges::fill(fresh.second, edges_->nodes[index(edge)][0]);
  }
  block.general.back().first[lane] = edges_->nodes[index(edge)][0];
  block.general.back().second[lane] = edges_->nodes[index(edge)][1];
  general_place_[index(edge)] = block.n_general++;
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
auto FixedPointForce<Real>::coefficients(std::int32_t edge) const -> Coefficients {
  Coefficients values{};
  if (const auto place = general_place_[index(edge)]; place >= 0) {
    const auto& group = blocks_[index(block_of_edge_[index(edge)])].general[index(place / 8)];
    for (std::size_t i = 0; i < 6; ++i) values[i] = group.s[i][place % 8];
    for (std::size_t i = 0; i < 3; ++i) values[6 + i] = group.w[i][place % 8];
  } else {
    const auto plain = plain_place_[index(edge)];
    for (std::size_t i = 0; i < 6; ++i) values[i] = stiffness_[index(plain / 8)].s[i][plain % 8];
  }
  return values;
}

template <class Real>
void FixedPointForce<Real>::set_coefficients(std::int32_t edge, const Coefficients& values) {
  if (const auto place = general_place_[index(edge)]; place >= 0) {
    auto& group = blocks_[index(block_of_edge_[index(edge)])].general[index(place / 8)];
    for (std::size_t i = 0; i < 6; ++i) group.s[i][place % 8] = values[i];
    for (std::size_t i = 0; i < 3; ++i) group.w[i][place % 8] = values[6 + i];
  } else {
    const auto plain = plain_place_[index(edge)];
    for (std::size_t i = 0; i < 6; ++i) stiffness_[index(plain / 8)].s[i][plain % 8] = values[i];
  }
}

template <class Real>
void FixedPointForce<Real>::find_reach() {
  for (std::int32_t b = 0; b < n_blocks(); ++b) {
    blocks_[index(b)].reach = {b, false};
    blocks_[index(b)].last_toucher = b;
  }
  for (std::size_t e = 0; e < edges_->size(); ++e) {
    const std::int32_t toucher = block_of_edge_[e];
    auto& reach = blocks_[index(toucher)].reach;
    for (const std::int32_t node : edges_->nodes[e]) {
      if (node >= subdomain_->n_owned) {
        reach.has_ghosts = true;
        continue;
      }
      const std::int32_t touched = node / nodes_per_block;
      reach.last_owned = std::max(reach.last_owned, touched);
      auto& last = blocks_[index(touched)].last_toucher;
      last = std::max(last, toucher);
    }
  }
}

template <class Real>
void FixedPointForce<Real>::add_block(std::int32_t number) {
  const Block& block = blocks_[index(number)];
  see(kernels_->add_edges(ends_.data() + block.first_pair, stiffness_.data() + block.first_pair,
                          block.last_pair - block.first_pair, nodes_.data()));
  see(kernels_->add_general_edges(block.general.data(), block.general.size(), nodes_.data()));
}

template <class Real>
void FixedPointForce<Real>::update(std::span<const std::int32_t> tetrahedra, bool force_is_current) {
  std::vector<std::int32_t> changed;
  for (const auto t : tetrahedra)
    for (const auto edge : edges_->of_tetrahedron[index(t)])
      if (edge >= 0) changed.push_back(edge);
  std::ranges::sort(changed);
  changed.erase(std::unique(changed.begin(), changed.end()), changed.end());

  const auto hand_on = [&](Real sign) {
    if (!force_is_current) return;
    for (std::size_t begin = 0; begin < changed.size(); begin += 8) {
      GeneralEdges<Real> group{};
      for (std::size_t lane = 0; lane < 8; ++lane) {
        const auto edge = changed[std::min(begin + lane, changed.size() - 1)];
        group.first[lane] = edges_->nodes[index(edge)][0];
        group.second[lane] = edges_->nodes[index(edge)][1];
        if (begin + lane >= changed.size()) continue;
        const Coefficients values = coefficients(edge);
        for (std::size_t i = 0; i < 6; ++i) group.s[i][lane] = sign * values[i];
        for (std::size_t i = 0; i < 3; ++i) group.w[i][lane] = sign * values[6 + i];
      }
      see(kernels_->add_general_edges(&group, 1, nodes_.data()));
    }
  };
  hand_on(-1);
  for (const auto edge : changed) {
    if (general_place_[index(edge)] < 0) {
      set_coefficients(edge, {});
      append_general(edge);
    }
    set_coefficients(edge, scaled(edge_coupling(*operators_, *elasticity_, *edges_, *integrity_, edge)));
  }
  hand_on(1);
}

template <class Real>
std::int64_t FixedPointForce<Real>::bytes_per_sweep() const {
  std::size_t bytes = ends_.size() * (sizeof(EdgeEnds) + sizeof(EdgeStiffness<Real>)) +
                      2 * nodes_.size() * sizeof(NodeRecord<Real>);
  for (const Block& block : blocks_) bytes += block.general.size() * sizeof(GeneralEdges<Real>);
  return static_cast<std::int64_t>(bytes);
}

template <class Real>
double FixedPointForce<Real>::padding() const {
  const auto n_edges =
      static_cast<double>(std::ranges::count_if(plain_place_, [](auto place) { return place >= 0; }));
  return n_edges > 0 ? 8 * static_cast<double>(ends_.size()) / n_edges - 1 : 0;
}

template <class Real>
double FixedPointForce<Real>::largest_stretch() const {
  Integer largest = 0;
  const auto look = [&](std::int32_t a, std::int32_t b) {
    for (std::size_t i = 0; i < 3; ++i) {
      const Integer d =
          kernels::difference(nodes_[index(b)].displacement[i], nodes_[index(a)].displacement[i]);
      largest = std::max(largest, d < 0 ? static_cast<Integer>(~d) : d);
    }
  };
  for (const EdgeEnds& pair : ends_)
    for (std::size_t lane = 0; lane < 8; ++lane) look(pair.owner[lane / 4], pair.target[lane]);
  for (const Block& block : blocks_) {
    for (const auto& group : block.general) {
      for (std::size_t lane = 0; lane < 8; ++lane) {
        const bool carries = group.s[0][lane] != 0 || group.s[1][lane] != 0 || group.s[2][lane] != 0;
        if (carries) look(group.first[lane], group.second[lane]);
      }
    }
  }
  return static_cast<double>(largest);
}

template class FixedPointForce<float>;
template class FixedPointForce<double>;

}  // namespace crackle::mechanics
