// SPDX-License-Identifier: GPL-3.0-or-later
#include "crackle/fracture/connectivity.h"

#include "crackle/geometry/dual_facets.h"
#include "crackle/parallel/agreement.h"
#include "crackle/parallel/node_field.h"

#include <algorithm>
#include <numeric>

namespace crackle::fracture {

namespace {

class DisjointSets {
public:
  explicit DisjointSets(std::size_t size) : parent_(size) { std::iota(parent_.begin(), parent_.end(), 0); }
  std::int32_t find(std::int32_t node) {
    while (parent_[static_cast<std::size_t>(node)] != node) {
      auto& parent = parent_[static_cast<std::size_t>(node)];
      parent = parent_[static_cast<std::size_t>(parent)];
      node = parent;
    }
    return node;
  }
  void join(std::int32_t a, std::int32_t b) { parent_[static_cast<std::size_t>(find(a))] = find(b); }

private:
  std::vector<std::int32_t> parent_;
};

}  // namespace

std::vector<std::int64_t> piece_labels(const parallel::Communicator& group, const BreakableBody& body) {
  const auto& subdomain = body.subdomain();
  DisjointSets pieces(subdomain.nodes.size());
  for (std::int32_t t = 0; t < subdomain.n_tetrahedra(); ++t) {
    const auto& nodes = subdomain.tetrahedra[static_cast<std::size_t>(t)];
    for (std::size_t k = 0; k < 6; ++k) {
      if (((body.integrity().released(t) >> k) & 1) != 0) continue;
      const auto [a, b] = geometry::dual_facet_nodes[k];
      pieces.join(nodes[a], nodes[b]);
    }
  }
  std::vector<std::int64_t> label = subdomain.node_number;
  parallel::NodeField exchanged(group, subdomain);
  for (int changed = 1; changed != 0;) {
    // Within the rank every piece takes its smallest label; then ghosts learn their owners' labels.
    std::vector<std::int64_t> smallest(label.size(), subdomain.n_nodes_global);
    for (std::size_t n = 0; n < label.size(); ++n) {
      auto& value = smallest[static_cast<std::size_t>(pieces.find(static_cast<std::int32_t>(n)))];
      value = std::min(value, label[n]);
    }
    for (std::size_t n = 0; n < label.size(); ++n) {
      label[n] = smallest[static_cast<std::size_t>(pieces.find(static_cast<std::int32_t>(n)))];
      exchanged.local()[3 * n] = static_cast<double>(label[n]);
    }
    if (group.size() == 1) break;
    parallel::agree(group);
    exchanged.update_ghosts();
    changed = 0;
    for (std::size_t n = static_cast<std::size_t>(subdomain.n_owned); n < label.size(); ++n) {
      const auto owners = static_cast<std::int64_t>(exchanged.local()[3 * n]);
      if (owners != label[n]) changed = 1;
      label[n] = std::min(label[n], owners);
    }
    parallel::check_mpi(MPI_Allreduce(MPI_IN_PLACE, &changed, 1, MPI_INT, MPI_MAX, group.get()),
                        "MPI_Allreduce");
  }
  return label;
}

}  // namespace crackle::fracture
