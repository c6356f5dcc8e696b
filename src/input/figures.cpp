// SPDX-License-Identifier: GPL-3.0-or-later
#include "figures.h"

#include "dimension.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numbers>

namespace crackle::input {

using plane::Point;
using plane::Polygon;
using plane::operator+;
using plane::operator-;
using plane::operator*;

namespace {

/// Ratio of the best tetrahedron that fits a corner to a realization's worst one.
constexpr double quality_reserve = 1.25;

/// The best mean-ratio quality of a tetrahedron in a wedge of this angle, with two corners on its edge.
double best_quality(double angle) {
  if (angle >= std::numbers::pi / 3) return 1;
  const double half = std::sin(angle / 2);
  const double square = 1 + half * half;  // squared edge length relative to the legs
  return 2 * std::pow(std::sin(angle) / 2, 2.0 / 3) * std::pow(square, -2.0 / 3);
}

/// Points where a region's limits of y or z cross an ellipse, within its limits of the other coordinate. Uses
/// only square roots, like plane::arc.
Polygon limits_on(const Ellipse& curve, const plane::Region& region) {
  Polygon places;
  for (std::size_t i = 0; i < 2; ++i)
    for (const double limit : {region[i + 1].first, region[i + 1].second}) {
      const double reach = plane::norm({curve.first[i], curve.second[i]});
      const double share = (limit - curve.centre[i]) / reach;
      if (!(std::abs(share) < 1)) continue;
      const double rest = std::sqrt(1 - share * share);
      for (const double side : {-rest, rest}) {
        const double cosine = (share * curve.first[i] - side * curve.second[i]) / reach;
        const double sine = (share * curve.second[i] + side * curve.first[i]) / reach;
        Point p = curve.centre + cosine * curve.first + sine * curve.second;
        p[i] = limit;
        const auto [lower, upper] = region[2 - i];
        if (lower <= p[1 - i] && p[1 - i] <= upper) places.push_back(p);
      }
    }
  return places;
}

/// A point of a curve replaces a corner closer than this share of the chord, unless that one must stay.
constexpr double replacing_share = 0.25;
/// Points of a curve closer than this share of a chord are identical.
constexpr double same_share = 1e-6;

}  // namespace

MeshSpacing::MeshSpacing(const Parameters& parameters) : mesh_(parameters.mesh) {
  for (const plane::Notch& notch : parameters.specimen.notches) {
    const double radius = notch.height / 2;
    if (notch.slot) {
      tips_.push_back({notch.slot->from, radius});
      tips_.push_back({notch.slot->to, radius});
    } else {
      const plane::Region slot = slot_of(notch, bounds_of(parameters.specimen));
      const auto [lower, upper] = slot[index(axis_of(notch.face))];
      Point tip{};
      tip[index(axis_of(notch.face)) - 1] = is_upper(notch.face) ? lower : upper;
      tip[index(position_axis(notch.face)) - 1] = notch.at;
      tips_.push_back({tip, radius});
    }
  }
}

double MeshSpacing::operator()(const Point& p) const {
  double spacing = mesh_.spacing;
  for (const auto& [tip, radius] : tips_)
    spacing =
        std::min(spacing, mesh_.notch_spacing + mesh_.growth * std::max(0.0, plane::norm(p - tip) - radius));
  for (const MeshRegion& region : mesh_.regions) {
    Point gap{};
    for (std::size_t i = 0; i < 2; ++i) {
      const auto [lower, upper] = region.box[i + 1];
      gap[i] = std::max({0.0, lower - p[i], p[i] - upper});
    }
    spacing = std::min(spacing, region.spacing + mesh_.growth * plane::norm(gap));
  }
  return spacing;
}

void insert_vertex(Polygon& corners, const Point& p, const Polygon& stays) {
  const auto nearest =
      std::ranges::min_element(corners, {}, [&](const Point& corner) { return plane::norm(corner - p); });
  const auto i = static_cast<std::size_t>(nearest - corners.begin());
  const std::size_t after = (i + 1) % corners.size();
  const bool is_after = plane::dot(p - corners[i], corners[after] - corners[i]) > 0;
  const Point& other = is_after ? corners[after] : corners[(i + corners.size() - 1) % corners.size()];
  const double gap = plane::norm(p - corners[i]);
  const double chord = plane::norm(other - corners[i]);
  const bool has_to_stay = std::ranges::any_of(
      stays, [&](const Point& one) { return plane::norm(one - corners[i]) <= same_share * chord; });
  if (gap <= same_share * chord && has_to_stay) return;
  if (gap < replacing_share * chord && !has_to_stay)
    corners[i] = p;
  else
    corners.insert(corners.begin() + static_cast<std::ptrdiff_t>(is_after ? i + 1 : i), p);
}

Polygon ShapeBuilder::ellipse(const Ellipse& curve, const std::string& name) const {
  Polygon corners = plane::arc(curve.centre, curve.first, curve.second, 4, spacing_);
  Polygon stays;
  // The extent of a circle along y and z determines that of the body.
  if (name.starts_with("edge"))
    stays = {curve.centre + curve.first, curve.centre + curve.second, curve.centre - curve.first,
             curve.centre - curve.second};
  for (const Boundary& condition : parameters_.boundaries) {
    if (condition.on != name) continue;
    for (const Point& limit : limits_on(curve, condition.region)) {
      insert_vertex(corners, limit, stays);
      stays.push_back(limit);
    }
  }
  if (name.starts_with("region")) return corners;
  for (const plane::MaterialRegion& region : parameters_.specimen.regions)
    for (const Point& place : intersections(corners, region.outline)) {
      insert_vertex(corners, place, stays);
      stays.push_back(place);
    }
  return corners;
}

std::optional<Polygon> ShapeBuilder::outline(const plane::Hole& figure, const std::string& key,
                                             const std::string& name, Findings& findings) const {
  if (findings.faulty(key)) return {};
  if (figure.polygon.empty()) {
    const Point along{std::cos(figure.angle), std::sin(figure.angle)};
    return counter_clockwise(
        ellipse({figure.center, figure.semi_axes[0] * along, figure.semi_axes[1] * left_of(along)}, name));
  }
  if (plane::is_simple(figure.polygon)) return counter_clockwise(figure.polygon);
  findings.report(key + ".polygon", "the polygon intersects itself; give its corners in order, each once");
  return {};
}

/// Where the sides of two polygons meet.
Polygon intersections(const Polygon& a, const Polygon& b) {
  Polygon places;
  for (std::size_t i = 0; i < a.size(); ++i)
    for (std::size_t j = 0; j < b.size(); ++j) {
      const Point& from = a[i];
      const Point& other = b[j];
      const Point along = a[(i + 1) % a.size()] - from;
      const Point way = b[(j + 1) % b.size()] - other;
      const double slope = plane::cross(along, way);
      if (slope == 0) continue;
      const double share = plane::cross(other - from, way) / slope;
      const double other_share = plane::cross(other - from, along) / slope;
      if (share >= 0 && share < 1 && other_share >= 0 && other_share < 1)
        places.push_back(other + other_share * way);
    }
  return places;
}

bool has_spacing(const Parameters& parameters, const Findings& findings) {
  return parameters.mesh.spacing > 0 && !findings.faulty("mesh.spacing") &&
         !findings.faulty("mesh.notch_spacing") && !findings.faulty("mesh.growth") &&
         !findings.faulty("mesh.region");
}

Polygon counter_clockwise(Polygon polygon) {
  if (plane::signed_area(polygon) < 0) std::ranges::reverse(polygon);
  return polygon;
}

std::string show_place(const Point& p) {
  return fmt::format("({}, {})", shown_length(p[0]), shown_length(p[1]));
}

void check_figure(const std::string& key, Findings& findings) {
  const auto given = [&](const char* name) { return findings.given(key + "." + name); };
  const int n_given = given("radius") + given("semi_axes") + given("polygon");
  if (n_given != 1)
    return findings.report(key, n_given == 0
                                    ? "has no shape; give one of radius, semi_axes and polygon"
                                    : "has several shapes; give one of radius, semi_axes and polygon");
  if (given("polygon") && given("center"))
    findings.report(key + ".center", "cannot be combined with polygon; leave it out");
  if (!given("polygon") && !given("center"))
    findings.report(key + ".center",
                    "the key is missing; give two lengths, y and z, such as [\"5 mm\", \"8 mm\"]");
  if (given("angle") && !given("semi_axes"))
    findings.report(key + ".angle", "applies to semi_axes only; leave it out");
}

bool check_chords(const std::string& key, const Polygon& corners, Findings& findings) {
  if (static_cast<double>(corners.size()) < 2 * plane::max_chords) return true;
  findings.report(key, "needs more than {} chords at the spacing there; give a coarser spacing",
                  corners.size());
  return false;
}

bool check_corner(const plane::Corner& corner, const std::string& name, const Parameters& parameters,
                  Findings& findings) {
  if (findings.faulty("mesh.min_quality")) return true;
  const double best = best_quality(corner.angle);
  if (best >= quality_reserve * parameters.mesh.min_quality) return true;
  findings.report("mesh.min_quality",
                  "{} has {:.3g} degrees, which limits the quality there to {:.2g}; give at most {:.2g}, or "
                  "a blunter corner",
                  name, corner.angle * 180 / std::numbers::pi, best, best / quality_reserve);
  return false;
}

}  // namespace crackle::input
