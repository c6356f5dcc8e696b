// SPDX-License-Identifier: GPL-3.0-or-later
#include "cracks/plane_traces.h"

#include "common/index.h"

#include "crack_graph.h"

#include <algorithm>
#include <array>
#include <cmath>
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

std::array<Vector, 2> axes_along(const input::SectionPlane& plane) {
  const Vector normal = plane.normal / norm(plane.normal);
  std::array<Vector, 2> axes{};
  std::size_t n = 0;
  for (std::size_t i = 0; i < 3 && n < 2; ++i)
    if (normal[i] == 0) axes[n++][i] = 1;
  if (n == 2) return axes;
  if (n == 0) {
    const Vector level{-normal[1], normal[0], 0};
    axes[0] = level / norm(level);
  }
  axes[1] = cross(normal, axes[0]);
  for (std::size_t i = 3; i-- > 0;) {
    if (axes[1][i] == 0) continue;
    if (axes[1][i] < 0) axes[1] = -1 * axes[1];
    break;
  }
  return axes;
}

std::vector<StartTrace> start_traces(const CrackSurface& surface, std::span<const input::SectionPlane> planes,
                                     std::size_t n_starts) {
  const std::size_t n_rows = n_trace_rows(n_starts);
  std::vector<StartTrace> rows(planes.size() * n_rows);
  std::vector<Vector> sums(rows.size());  // of places times lengths
  for (const PlaneTrace& trace : plane_traces(surface, planes)) {
    const std::int32_t start = surface.cracks[index(trace.crack)].start;
    for (const std::size_t k : {start < 0 ? n_starts : index(start), n_starts + 1}) {
      const std::size_t row = index(trace.plane) * n_rows + k;
      rows[row].length += trace.length;
      rows[row].time = std::fmin(rows[row].time, trace.first_time);
      sums[row] = sums[row] + trace.length * trace.position;
    }
  }
  for (std::size_t row = 0; row < rows.size(); ++row) {
    if (!(rows[row].length > 0)) continue;
    const input::SectionPlane& plane = planes[row / n_rows];
    const auto [along, across] = axes_along(plane);
    const Vector place = sums[row] / rows[row].length - plane.point;
    rows[row].along = dot(place, along);
    rows[row].across = dot(place, across);
  }
  return rows;
}

}  // namespace crackle::cracks
