// SPDX-License-Identifier: GPL-3.0-or-later
#include "cracks/plane_traces.h"

#include "common/index.h"

#include <algorithm>
#include <array>
#include <map>
#include <optional>

namespace crackle::cracks {

namespace {

using geometry::Point;

/// The line in which a plane cuts a convex quadrilateral.
std::optional<std::array<Point, 2>> cut(const std::array<Point, 4>& corner,
                                        const input::SectionPlane& plane) {
  std::array<double, 4> height{};
  for (std::size_t i = 0; i < 4; ++i) height[i] = dot(plane.normal, corner[i] - plane.point);
  std::array<Point, 2> ends{};
  std::size_t n = 0;
  for (std::size_t i = 0; i < 4; ++i) {
    const std::size_t next = (i + 1) % 4;
    if ((height[i] < 0) == (height[next] < 0) || n == 2) continue;
    ends[n++] = corner[i] + height[i] / (height[i] - height[next]) * (corner[next] - corner[i]);
  }
  if (n < 2) return {};
  return ends;
}

}  // namespace

std::vector<PlaneTrace> plane_traces(const CrackSurface& surface,
                                     std::span<const input::SectionPlane> planes) {
  std::vector<PlaneTrace> traces;
  for (std::size_t plane = 0; plane < planes.size(); ++plane) {
    std::map<std::int32_t, PlaneTrace> of_crack;
    for (const CrackFacet& facet : surface.facets) {
      const auto ends = cut(facet.corner, planes[plane]);
      if (!ends) continue;
      const double length = norm((*ends)[1] - (*ends)[0]);
      const auto number = static_cast<std::int32_t>(plane);
      auto& trace =
          of_crack.try_emplace(facet.crack, PlaneTrace{number, facet.crack, 0, {}, facet.time}).first->second;
      trace.length += length;
      trace.position = trace.position + length / 2 * ((*ends)[0] + (*ends)[1]);
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
