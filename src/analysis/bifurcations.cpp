// SPDX-License-Identifier: GPL-3.0-or-later
#include "crackle/analysis/crack_path.h"

#include "slabs.h"

#include <algorithm>

namespace crackle::analysis {

std::int32_t count_bifurcations(const geometry::Body& body, const CrackSurface& surface) {
  std::int32_t n_bifurcations = 0;
  for (int notch = 0; notch < body.n_notches(); ++notch) {
    const std::vector<std::size_t> facets = facets_of_notch(surface, notch);
    if (facets.empty()) continue;
    const std::vector<Slab> slabs = cut_in_slabs(surface, facets, notch_frame(body, notch),
                                                 mean_spacing(surface, facets), body.size()[0]);
    for (std::size_t k = 0; k < slabs.size(); ++k) {
      for (const Piece& piece : slabs[k]) {
        n_bifurcations += std::max(0, static_cast<int>(separate_ways(slabs, k, piece).size()) - 1);
      }
    }
  }
  return n_bifurcations;
}

}  // namespace crackle::analysis
