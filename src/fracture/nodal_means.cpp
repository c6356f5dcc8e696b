// SPDX-License-Identifier: GPL-3.0-or-later
#include "fracture/nodal_means.h"

#include <map>
#include <utility>

namespace crackle::fracture {

NodalMeans::NodalMeans(const BreakableBody& body, const mechanics::NodeTetrahedra& round_node)
    : body_(&body), round_node_(&round_node), n_patches_(body.subdomain().layout.n_owned) {
  const auto& subdomain = body.subdomain();
  bool is_uniform = true;
  for (std::int32_t t = 1; t < subdomain.n_tetrahedra(); ++t) is_uniform = is_uniform && kind(t) == kind(0);
  if (is_uniform) return;
  std::map<std::pair<std::int32_t, std::int32_t>, std::int32_t> numbers;  // by node and kind
  for (std::int32_t t = 0; t < subdomain.n_tetrahedra(); ++t) {
    auto& patches = patches_.emplace_back();
    for (std::size_t corner = 0; corner < 4; ++corner) {
      const auto node = subdomain.tetrahedra[index(t)][corner];
      patches[corner] =
          node < subdomain.layout.n_owned
              ? numbers.try_emplace({node, kind(t)}, static_cast<std::int32_t>(numbers.size())).first->second
              : -1;
    }
  }
  n_patches_ = static_cast<std::int32_t>(numbers.size());
}

}  // namespace crackle::fracture
