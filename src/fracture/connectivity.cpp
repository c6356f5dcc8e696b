// SPDX-License-Identifier: GPL-3.0-or-later
#include "crackle/fracture/connectivity.h"

#include "crackle/common/disjoint_sets.h"
#include "crackle/common/index.h"
#include "crackle/geometry/dual_facets.h"
#include "crackle/parallel/agreement.h"
#include "crackle/parallel/collectives.h"
#include "crackle/parallel/ghost_exchange.h"

#include <algorithm>

namespace crackle::fracture {

std::vector<std::int64_t> piece_labels(const parallel::Communicator& group, const BreakableBody& body) {
  const auto& subdomain = body.subdomain();
  DisjointSets pieces(subdomain.nodes.size());
  for (std::int32_t t = 0; t < subdomain.n_tetrahedra(); ++t) {
    const auto& nodes = subdomain.tetrahedra[index(t)];
    for (std::size_t k = 0; k < 6; ++k) {
      if (((body.residual_stiffness().released(t) >> k) & 1) != 0) continue;
      const auto [a, b] = geometry::dual_facet_nodes[k];
      pieces.join(index(nodes[a]), index(nodes[b]));
    }
  }
  std::vector<std::int64_t> label = subdomain.layout.number;
  std::vector<std::int64_t> of_owner(label.size());
  parallel::GhostExchange<std::int64_t> exchange(group, subdomain.layout);
  for (bool changed = true; changed;) {
    // Within the rank every piece takes its smallest label; then ghosts learn their owners' labels.
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
    parallel::agree(group);
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

}  // namespace crackle::fracture
