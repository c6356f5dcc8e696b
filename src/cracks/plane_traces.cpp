// SPDX-License-Identifier: GPL-3.0-or-later
#include "cracks/plane_traces.h"

#include "crack_graph.h"

#include <algorithm>
#include <array>
#include <map>

namespace crackle::cracks {

std::vector<PlaneTrace> plane_traces(const CrackSurface& surface,
                                     std::span<const input::SectionPlane> planes) {
  std::vector<PlaneTrace> traces;
  for (std::size_t plane = 0; plane < planes.size(); ++plane) {
    const Vector& normal = planes[plane].normal;
    const double position = dot(normal, planes[plane].point);
    std::map<std::int32_t, PlaneTrace> of_crack;
    for (const CrackFacet& facet : surface.facets) {
      const auto sides = passages(facet, normal, position);
      if (!sides) continue;
      std::array<geometry::Point, 2> ends{};
      for (std::size_t i = 0; i < 2; ++i) {
        const auto& [from, to, share] = (*sides)[i];
        ends[i] = facet.corner[from] + share * (facet.corner[to] - facet.corner[from]);
      }
      const double length = norm(ends[1] - ends[0]);
      const auto number = static_cast<std::int32_t>(plane);
      auto& trace =
          of_crack.try_emplace(facet.crack, PlaneTrace{number, facet.crack, 0, {}, facet.time}).first->second;
      trace.length += length;
      trace.position = trace.position + length / 2 * (ends[0] + ends[1]);
      trace.first_time = std::min(trace.first_time, facet.time);
    }
    for (auto& [crack, trace] : of_crack) {
      if (trace.length <= 0) continue;
      trace.position = trace.position / trace.length;
      traces.push_back(trace);
    }
  }
  return traces;
}

}  // namespace crackle::cracks
