// SPDX-License-Identifier: GPL-3.0-or-later
#include "fracture/release.h"

#include "fracture/softening.h"
#include "geometry/dual_facets.h"

#include <algorithm>

namespace crackle::fracture {

double Release::remaining(std::int32_t tetrahedron, double since_break) const {
  const double time = course_.time[tetrahedron];
  if (time == 0) return 0;
  return std::max(0.0, 1 - (since_break + course_.step / 2) / time);
}

mechanics::EdgeSet FacetRelease::edges(int cut) const {
  return crossed_edges(cut);
}

mechanics::EdgeSet crossed_edges(int cut) {
  // The group of corner 0 for 2|2 cuts; the single corner for 1|3 cuts.
  const unsigned group = cut < 4 ? 1U << cut : 1U | (1U << (cut - 3));
  unsigned crossed = 0;
  for (std::size_t k = 0; k < 6; ++k) {
    const auto [a, b] = geometry::dual_facet_nodes[k];
    if (((group >> a) & 1U) != ((group >> b) & 1U)) crossed |= 1U << k;
  }
  return static_cast<mechanics::EdgeSet>(crossed);
}

std::unique_ptr<Release> make_release(const input::Fracture& fracture, Release::Course course,
                                      std::vector<double> dissipation) {
  switch (fracture.release) {
    case input::Release::element:
      return std::make_unique<ElementRelease>(std::move(course));
    case input::Release::facet:
      return std::make_unique<FacetRelease>(std::move(course));
    case input::Release::softening:
      return std::make_unique<Softening>(SofteningLaw(fracture.softening, fracture.teeth),
                                         std::move(dissipation), std::move(course));
  }
  return nullptr;
}

}  // namespace crackle::fracture
