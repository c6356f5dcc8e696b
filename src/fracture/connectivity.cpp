// SPDX-License-Identifier: GPL-3.0-or-later
#include "fracture/connectivity.h"

#include "common/disjoint_sets.h"
#include "common/index.h"
#include "geometry/dual_facets.h"
#include "parallel/agreement.h"
#include "parallel/collectives.h"
#include "parallel/ghost_exchange.h"

#include <algorithm>
#include <array>
#include <unordered_map>

namespace crackle::fracture {

namespace {

/// Joins the parts of pieces on several ranks: maps each label to the smallest one of its piece. Collective.
std::unordered_map<std::int64_t, std::int64_t> joined_labels(const parallel::Communicator& group,
                                                             const geometry::Subdomain& subdomain,
                                                             const std::vector<std::int64_t>& label) {
  // Tetrahedra shared with other ranks, with the labels assigned by each.
  const auto mine = parallel::agree(group, [&] {
    std::vector<std::int64_t> pairs;
    for (std::size_t t = 0; t < label.size(); ++t) {
      const bool is_shared = std::ranges::any_of(
          subdomain.tetrahedra[t], [&](std::int32_t node) { return node >= subdomain.layout.n_owned; });
      if (is_shared && label[t] >= 0) pairs.insert(pairs.end(), {subdomain.tetrahedron_number[t], label[t]});
    }
    return pairs;
  });
  const auto all = parallel::gather_all<std::int64_t>(group, mine);
  return parallel::agree(group, [&] {
    std::vector<std::int64_t> numbers(all.begin(), all.end());
    std::ranges::sort(numbers);
    numbers.erase(std::unique(numbers.begin(), numbers.end()), numbers.end());
    const auto place = [&](std::int64_t number) {
      return static_cast<std::size_t>(std::ranges::lower_bound(numbers, number) - numbers.begin());
    };
    DisjointSets pieces(numbers.size());
    for (std::size_t i = 0; i < all.size(); i += 2) pieces.join(place(all[i]), place(all[i + 1]));
    std::unordered_map<std::int64_t, std::int64_t> joined;
    for (std::size_t i = 0; i < numbers.size(); ++i) joined[numbers[i]] = numbers[pieces.smallest(i)];
    return joined;
  });
}

}  // namespace

bool carries_face(mechanics::EdgeSet released, std::size_t corner) {
  if (released == mechanics::no_edge) return true;
  for (std::size_t k = 0; k < 6; ++k) {
    const auto [a, b] = geometry::dual_facet_nodes[k];
    if (a != corner && b != corner && ((released >> k) & 1) != 0) return false;
  }
  return true;
}

std::vector<std::int64_t> piece_labels(const parallel::Communicator& group, const BreakableBody& body) {
  const auto& subdomain = body.subdomain();
  DisjointSets pieces(subdomain.nodes.size());
  for (std::int32_t t = 0; t < subdomain.n_tetrahedra(); ++t) {
    const auto& nodes = subdomain.tetrahedra[index(t)];
    const mechanics::EdgeSet released = body.residual_stiffness().released(t);
    // The first three edges connect all corners.
    for (std::size_t k = 0; k < (released == mechanics::no_edge ? 3 : 6); ++k) {
      if (((released >> k) & 1) != 0) continue;
      const auto [a, b] = geometry::dual_facet_nodes[k];
      pieces.join(index(nodes[a]), index(nodes[b]));
    }
  }
  std::vector<std::int64_t> label = subdomain.layout.number;
  std::vector<std::int64_t> of_owner(label.size());
  parallel::GhostExchange<std::int64_t> exchange(group, subdomain.layout);
  for (bool changed = true; changed;) {
    // Within the rank each piece takes its smallest label; then ghosts receive their owners' labels.
    std::vector<std::int64_t> smallest(label.size(), subdomain.layout.n_global);
    for (std::size_t n = 0; n < label.size(); ++n) {
      auto& value = smallest[pieces.smallest(n)];
      value = std::min(value, label[n]);
    }
    for (std::size_t n = 0; n < label.size(); ++n) {
      label[n] = smallest[pieces.smallest(n)];
    }
    if (group.size() == 1) break;
    of_owner = label;
    parallel::check_peers(group);
    exchange.update(of_owner);
    changed = false;
    for (std::size_t n = static_cast<std::size_t>(subdomain.layout.n_owned); n < label.size(); ++n) {
      if (of_owner[n] != label[n]) changed = true;
      label[n] = std::min(label[n], of_owner[n]);
    }
    changed = parallel::any_of_all(group, changed);
  }
  return label;
}

std::vector<std::int64_t> face_piece_labels(const parallel::Communicator& group, const BreakableBody& body) {
  const auto& subdomain = body.subdomain();
  const auto& stiffness = body.residual_stiffness();
  std::vector<std::int64_t> label = parallel::agree(group, [&] {
    const auto& neighbours = body.face_neighbours();
    DisjointSets pieces(neighbours.size());
    const auto released = [&](std::int32_t t) { return stiffness.released(t); };
    for (std::size_t t = 0; t < neighbours.size(); ++t)
      for (std::size_t corner = 0; corner < 4; ++corner)
        if (const std::int32_t other = neighbours[t][corner];
            other > static_cast<std::int32_t>(t) &&
            is_connected_across(body, static_cast<std::int32_t>(t), corner, released))
          pieces.join(t, index(other));
    std::vector<std::int64_t> labels;
    labels.reserve(neighbours.size());
    for (std::size_t t = 0; t < neighbours.size(); ++t)
      labels.push_back(stiffness.carries(static_cast<std::int32_t>(t))
                           ? subdomain.tetrahedron_number[pieces.smallest(t)]
                           : -1);
    return labels;
  });
  if (group.size() == 1) return label;
  const auto joined = joined_labels(group, subdomain, label);
  for (auto& value : label)
    if (const auto found = joined.find(value); found != joined.end()) value = found->second;
  return label;
}

}  // namespace crackle::fracture
