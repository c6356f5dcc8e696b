// SPDX-License-Identifier: GPL-3.0-or-later
#include "cracks/section_crossings.h"

#include "common/real.h"

#include "crack_graph.h"

namespace crackle::cracks {

std::vector<geometry::CrossPlane> planes_of(const input::Sections& sections) {
  std::vector<geometry::CrossPlane> planes;
  for (const input::Section& section : sections.all()) planes.push_back(geometry::plane_of(section));
  return planes;
}

std::vector<SectionCrossing> section_crossings(const geometry::Body& body, const CrackSurface& surface,
                                               const CrackBranches& branches,
                                               std::span<const geometry::CrossPlane> sections) {
  std::vector<SectionCrossing> crossings;
  for (std::size_t number = 0; number < body.crack_starts().size(); ++number) {
    const Indices facets = facets_from(surface, static_cast<std::int32_t>(number));
    const geometry::CrackStart& start = body.crack_starts()[number];
    for (const geometry::CrossPlane& plane : sections) {
      std::optional<Crossing> crossing;
      if (!start.is_straight || start.advance_to(plane))
        crossing = main_crossing(intersect(surface, facets, plane), Projection(body).thickness(),
                                 branches.branch, &plane);
      crossings.push_back(
          crossing ? SectionCrossing{crossing->mean, crossing->spread, crossing->arrival, crossing->branches}
                   : SectionCrossing{not_a_number, not_a_number, not_a_number, {}});
    }
  }
  return crossings;
}

}  // namespace crackle::cracks
