// SPDX-License-Identifier: GPL-3.0-or-later
#include "cracks/crack_ligaments.h"

#include "common/disjoint_sets.h"
#include "common/index.h"
#include "common/vector.h"

#include "crack_graph.h"

#include <algorithm>
#include <cmath>
#include <iterator>
#include <map>
#include <optional>
#include <utility>

namespace crackle::cracks {

namespace {

using geometry::CrackStart;
using geometry::Point;

/// The point of a patch closest to p.
Point nearest_point(const geometry::Patch& patch, const Point& p) {
  Point own{};
  for (std::size_t i = 0; i < 3; ++i)
    own[i] = std::clamp(dot(p - patch.origin, patch.axes[i]), patch.domain.lower[i], patch.domain.upper[i]);
  return patch.at(own);
}

/// Finds where a ligament leaves the body.
class Exit {
public:
  explicit Exit(const geometry::Body& body) : polygons_(body.outline()) {}

  /// The distance at which a ray in the plane leaves the body, beyond `least`: a ray from inside crosses
  /// the outline an odd number of times. `least` if it is already outside, by rounding.
  double distance(const Point& from, const Vector& along, double least) const {
    std::vector<double> passages;
    for (const geometry::Polygon& polygon : polygons_) {
      for (std::size_t i = 0; i < polygon.size(); ++i) {
        const auto passage = meet(from, along, polygon[i], polygon[(i + 1) % polygon.size()]);
        if (passage && *passage > least) passages.push_back(*passage);
      }
    }
    std::ranges::sort(passages);
    return passages.size() % 2 == 1 ? passages[0] : least;
  }

private:
  static std::optional<double> meet(const Point& from, const Vector& along, const std::array<double, 2>& a,
                                    const std::array<double, 2>& b) {
    const auto [y, z] = Projection::in_plane(from);
    const auto [along_y, along_z] = Projection::in_plane(along);
    const auto side = [&](const std::array<double, 2>& p) {
      return along_y * (p[1] - z) - along_z * (p[0] - y);
    };
    const double first = side(a);
    const double second = side(b);
    // Half-open intervals, so that a corner on the ray belongs to only one of its edges.
    if ((first < 0) == (second < 0)) return std::nullopt;
    const double share = first / (first - second);
    return along_y * (a[0] + share * (b[0] - a[0]) - y) + along_z * (a[1] + share * (b[1] - a[1]) - z);
  }

  const std::vector<geometry::Polygon>& polygons_;
};

/// The ligaments that follow from the cracks of a start.
class LigamentFinder {
public:
  LigamentFinder(const geometry::Body& body, const CrackSurface& surface, std::int32_t number)
      : surface_(surface),
        number_(number),
        start_(body.crack_starts()[index(number)]),
        projection_(body),
        exit_(body) {
    if (start_.plane) faces_.push_back(*start_.plane);
    // A crack of the free surface touches no other start, so their faces are irrelevant.
    for (std::size_t face = 0; face < body.faces().size(); ++face) {
      const bool is_own =
          start_.is_free_surface ||
          std::ranges::find(start_.faces, static_cast<geometry::FaceId>(face)) != start_.faces.end();
      // Faces that are seen from the front touch the crack along its whole length, so they are excluded.
      if (is_own && !Projection::faces(body.faces()[face].outward))
        faces_.push_back(body.faces()[face].patch);
    }
  }

  /// Of the single cracks.
  std::vector<CrackLigament> ligaments() const {
    return ligaments(facets_begun_at(surface_, number_), [](std::int32_t crack) { return crack; });
  }

  /// Of cracks together with those that continue them behind holes.
  std::vector<CrackLigament> through_holes() const {
    return ligaments(facets_from(surface_, number_), [&](std::int32_t crack) {
      while (crack >= 0 && surface_.cracks[index(crack)].hole >= 0)
        crack = entering(surface_.cracks[index(crack)].hole);
      return crack;
    });
  }

private:
  /// The crack that those of a hole continue; if there is none, a number of its own.
  std::int32_t entering(std::int32_t hole) const {
    const auto entry = std::ranges::find(surface_.entries, hole, &HoleEntry::hole);
    return entry != surface_.entries.end() && entry->crack >= 0 ? entry->crack : -1 - hole;
  }

  /// @param joined number shared by cracks that count as one
  std::vector<CrackLigament> ligaments(const Indices& all, const auto& joined) const {
    std::map<std::int32_t, Indices> cracks;
    for (const std::size_t i : all) cracks[joined(surface_.facets[i].crack)].push_back(i);
    std::vector<CrackLigament> found;
    for (const auto& [crack, facets] : cracks) {
      const double least = min_crack_length * mean_spacing(surface_, facets);
      const std::vector<Point> roots = start_.is_straight ? std::vector{start_.tip} : roots_of(facets);
      std::vector<Indices> of_root(roots.size());
      for (const std::size_t i : facets) of_root[nearest(roots, centre(i))].push_back(i);
      for (std::size_t i = 0; i < roots.size(); ++i) add_ligaments(found, roots[i], of_root[i], least);
    }
    return found;
  }

  Point centre(std::size_t facet) const {
    const auto& corner = surface_.facets[facet].corner;
    return projection_.projected((corner[0] + corner[1] + corner[2] + corner[3]) / 4);
  }

  static std::size_t nearest(const std::vector<Point>& points, const Point& p) {
    const auto distance = [&](const Point& point) { return norm(point - p); };
    return static_cast<std::size_t>(std::ranges::min_element(points, {}, distance) - points.begin());
  }

  /// The point of the start's faces closest to a facet, if within one spacing.
  std::optional<Point> touch(std::size_t facet) const {
    double least = local_spacing(surface_.facets[facet]);
    std::optional<Point> found;
    for (const geometry::Patch& patch : faces_) {
      for (const Point& corner : surface_.facets[facet].corner) {
        const Point p = nearest_point(patch, corner);
        if (const double distance = norm(p - corner); distance <= least) {
          least = distance;
          found = projection_.projected(p);
        }
      }
    }
    return found;
  }

  std::vector<Point> roots_of(const Indices& facets) const {
    const double spacing = mean_spacing(surface_, facets);
    std::vector<Point> touches;
    for (const std::size_t i : facets)
      if (const auto p = touch(i)) touches.push_back(*p);
    DisjointSets places(touches.size());
    for (std::size_t i = 0; i < touches.size(); ++i)
      for (std::size_t j = 0; j < i; ++j)
        if (norm(touches[i] - touches[j]) <= root_gap * spacing) places.join(i, j);
    struct Place {
      Point sum{};
      double n = 0;
      double from_first;  ///< distance from where the crack opened first
    };
    const Point first = first_place(facets);
    std::map<std::size_t, Place> found;
    for (std::size_t i = 0; i < touches.size(); ++i) {
      const double distance = norm(touches[i] - first);
      Place& place = found.try_emplace(places.smallest(i), Place{{}, 0, distance}).first->second;
      place.sum = place.sum + touches[i];
      place.n += 1;
      place.from_first = std::min(place.from_first, distance);
    }
    std::vector<Point> roots;
    double least = min_crack_length * spacing;
    for (const auto& [number, place] : found) {
      // Other contacts are where a crack of the free surface arrived.
      if (start_.is_free_surface && place.from_first >= least) continue;
      if (start_.is_free_surface) {
        roots.clear();
        least = place.from_first;
      }
      roots.push_back(place.sum / place.n);
    }
    return roots.empty() ? std::vector{first} : roots;
  }

  /// Mean position of the tetrahedron that broke first.
  Point first_place(const Indices& facets) const {
    Point sum{};
    double n = 0;
    for (const std::size_t i : facets) {
      if (surface_.facets[i].tetrahedron != surface_.facets[facets.front()].tetrahedron) break;
      sum = sum + centre(i);
      n += 1;
    }
    return sum / n;
  }

  void add_ligaments(std::vector<CrackLigament>& found, const Point& root, const Indices& facets,
                     double least) const {
    const auto farthest = farthest_from(root, facets);
    if (!farthest || norm(*farthest) < least) return;
    Indices ahead, behind;
    for (const std::size_t i : facets) (dot(centre(i) - root, *farthest) >= 0 ? ahead : behind).push_back(i);
    const auto backwards = farthest_from(root, behind);
    const bool is_both = backwards && norm(*backwards) >= least;
    found.push_back(ligament(root, *farthest, is_both ? std::move(ahead) : facets));
    if (is_both) found.push_back(ligament(root, *backwards, std::move(behind)));
  }

  /// Vector from the root to the farthest facet.
  std::optional<Vector> farthest_from(const Point& root, const Indices& facets) const {
    std::optional<Vector> farthest;
    for (const std::size_t i : facets) {
      const Vector to_facet = centre(i) - root;
      if (!farthest || norm(to_facet) > norm(*farthest)) farthest = to_facet;
    }
    return farthest;
  }

  CrackLigament ligament(const Point& root, const Vector& to_farthest, Indices facets) const {
    const Crack& crack = surface_.cracks[index(surface_.facets[facets.front()].crack)];
    CrackLigament found{crack.start, number_, start_, std::move(facets)};
    CrackStart& line = found.line;
    const double length = norm(to_farthest);
    line.tip = root;
    line.along = to_farthest / length;
    line.across = Projection::across(line.along);
    line.direction = 1;
    line.ligament = exit_.distance(root, line.along, length);
    line.end = root + line.ligament * line.along;
    return found;
  }

  const CrackSurface& surface_;
  std::int32_t number_;
  const CrackStart& start_;
  Projection projection_;
  std::vector<geometry::Patch> faces_;
  Exit exit_;
};

}  // namespace

std::vector<CrackLigament> crack_ligaments(const geometry::Body& body, const CrackSurface& surface,
                                           std::int32_t start, Followed followed) {
  const CrackStart& from = body.crack_starts()[index(start)];
  const bool is_through = followed == Followed::through_holes;
  if (from.is_straight && followed != Followed::chords)
    return {{start, start, from, is_through ? facets_from(surface, start) : facets_begun_at(surface, start)}};
  const LigamentFinder finder(body, surface, start);
  return is_through ? finder.through_holes() : finder.ligaments();
}

std::vector<CrackLigament> crack_ligaments(const geometry::Body& body, const CrackSurface& surface,
                                           Followed followed) {
  std::vector<CrackLigament> all;
  for (std::size_t start = 0; start < body.crack_starts().size(); ++start)
    std::ranges::move(crack_ligaments(body, surface, static_cast<std::int32_t>(start), followed),
                      std::back_inserter(all));
  return all;
}

}  // namespace crackle::cracks
