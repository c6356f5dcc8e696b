// SPDX-License-Identifier: GPL-3.0-or-later
#include "cracks/crack_line.h"

#include "common/index.h"
#include "cracks/crack_ligaments.h"

#include "crack_graph.h"
#include "polyline.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <iterator>
#include <map>
#include <numbers>
#include <span>
#include <utility>

namespace crackle::cracks {

namespace {

/// Stations per slab at which a path's direction is measured; the middle one is the line's point.
constexpr int n_stations_per_slab = 3;

/// The angle from one direction to another, in [-pi, pi] [rad].
double deflection(double from, double to) {
  return std::remainder(to - from, 2 * std::numbers::pi);
}

/// Traces the lines of the branches of the crack on one ligament.
class Tracer {
public:
  Tracer(const geometry::Body& body, const CrackSurface& surface, const CrackLigament& ligament)
      : surface_(surface),
        ligament_(ligament),
        start_(ligament.line),
        spacing_(mean_spacing(surface, ligament.facets)),
        projection_(body) {}

  /// Adds the main line and its branches to `lines`.
  void trace(std::vector<CrackLine>& lines, const CrackBranches& branches) const {
    struct Traced {
      std::size_t line;
      Path path;
    };
    std::map<std::int32_t, Traced> traced;
    // A branch has a higher number than the one it leaves.
    for (const auto& [branch, facets] : by_branch(ligament_.facets, branches)) {
      Path path = CrackGraph(projection_, surface_, facets, start_, spacing_).longest_path(branch == 0);
      if (path.empty()) continue;
      auto parent = traced.end();
      for (std::int32_t left = branch; left > 0 && parent == traced.end();)
        parent = traced.find(left = branches.points[index(left - 1)].parent);
      std::int32_t parent_line = -1;
      if (parent != traced.end()) {
        parent_line = static_cast<std::int32_t>(parent->second.line);
        const Path& along = parent->second.path;
        const auto beyond = std::ranges::lower_bound(along, path.front().level, {}, &PathLink::level);
        if (beyond != along.begin()) path.insert(path.begin(), *std::prev(beyond));
      }
      add(lines, parent_line, path);
      traced[branch] = {lines.size() - 1, std::move(path)};
    }
  }

private:
  void add(std::vector<CrackLine>& lines, std::int32_t parent, const Path& path) const {
    CrackLine line{ligament_.start, parent, {}, 0, 0};
    std::vector<Polyline::Place> places;
    for (const PathLink& link : path) {
      for (int i = 0; i < n_stations_per_slab; ++i) {
        const double advance = (static_cast<double>(link.level) + (i + 0.5) / n_stations_per_slab) * spacing_;
        const geometry::CrossPlane plane = start_.plane_at(advance);
        const auto traces = intersect(surface_, link.facets, plane);
        const auto crossing = main_crossing(traces, projection_.thickness());
        if (!crossing) continue;  // the rough edges of a piece can leave gaps
        places.push_back({advance, crossing->mean});
        if (i != n_stations_per_slab / 2) continue;
        const auto [y, z] = Projection::in_plane(plane.at(crossing->mean));
        line.points.push_back({y, z, crossing->spread, crossing->arrival});
      }
    }
    if (places.size() > 1) measure_deflections(line, Polyline(std::move(places)));
    lines.push_back(std::move(line));
  }

  void measure_deflections(CrackLine& line, const Polyline& path) const {
    const double window = std::max(kink_window_share * start_.ligament, kink_window_spacings * spacing_);
    if (path.length() < 2 * window) return;
    line.bend = deflection(path.direction(0, window), path.direction(path.length() - window, path.length()));

    constexpr std::ptrdiff_t n_steps = 16;  // per window
    std::vector<double> deflections;
    for (double place = window; place <= path.length() - window; place += window / n_steps) {
      deflections.push_back(
          std::abs(deflection(path.direction(place - window, place), path.direction(place, place + window))));
    }
    for (auto here = deflections.begin(); here != deflections.end(); ++here) {
      if (*here < kink_angle) continue;
      const auto low = here - std::min(n_steps, here - deflections.begin());
      const auto high = here + std::min(n_steps + 1, deflections.end() - here);
      if (std::max_element(low, high) == here) ++line.kinks;
    }
  }

  const CrackSurface& surface_;
  const CrackLigament& ligament_;
  const geometry::CrackStart& start_;
  double spacing_;
  Projection projection_;
};

}  // namespace

std::vector<CrackLine> crack_lines(const geometry::Body& body, const CrackSurface& surface,
                                   const CrackBranches& branches) {
  std::vector<CrackLine> lines;
  for (const CrackLigament& ligament : crack_ligaments(body, surface))
    if (!ligament.facets.empty()) Tracer(body, surface, ligament).trace(lines, branches);
  return lines;
}

std::int32_t count_kinks(const std::vector<CrackLine>& lines) {
  std::int32_t n_kinks = 0;
  for (const CrackLine& line : lines) n_kinks += line.kinks;
  return n_kinks;
}

}  // namespace crackle::cracks
