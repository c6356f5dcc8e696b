// SPDX-License-Identifier: GPL-3.0-or-later
// The shape of the body in the plane of the plate.
#include "consistency.h"
#include "dimension.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <numbers>
#include <string>
#include <utility>
#include <vector>

namespace crackle::input {

namespace {

/// Points this close to the surface, relative to the body's size, are on it.
constexpr double on_surface = 1e-9;
/// Ratio of the best tetrahedron that fits a corner to a realization's worst one.
constexpr double quality_reserve = 1.25;

using plane::Point;
using plane::Polygon;
using plane::operator+;
using plane::operator-;
using plane::operator*;

Point direction_of(const Point& vector) {
  return 1 / plane::norm(vector) * vector;
}

Point left_of(const Point& vector) {
  return {-vector[1], vector[0]};
}

std::string show_place(const Point& p) {
  return fmt::format("({}, {})", input::show(p[0]), input::show(p[1]));
}

/// The point distance required by the mesh, regardless of the body's shape.
class MeshSpacing {
public:
  explicit MeshSpacing(const Parameters& parameters) : mesh_(parameters.mesh) {
    for (const Notch& notch : parameters.specimen.notches) {
      const double radius = notch.height / 2;
      if (notch.slot) {
        tips_.push_back({notch.slot->from, radius});
        tips_.push_back({notch.slot->to, radius});
      } else {
        const Region slot = slot_of(notch, parameters.specimen.size);
        const auto [lower, upper] = slot[index(axis_of(notch.face))];
        Point tip{};
        tip[index(axis_of(notch.face)) - 1] = is_upper(notch.face) ? lower : upper;
        tip[index(position_axis(notch.face)) - 1] = notch.at;
        tips_.push_back({tip, radius});
      }
    }
  }

  double operator()(const Point& p) const {
    double spacing = mesh_.spacing;
    for (const auto& [tip, radius] : tips_)
      spacing = std::min(spacing,
                         mesh_.notch_spacing + mesh_.growth * std::max(0.0, plane::norm(p - tip) - radius));
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

private:
  struct Tip {
    Point place;
    double radius;
  };
  const Mesh& mesh_;
  std::vector<Tip> tips_;
};

/// A figure cut out of the outline.
struct Cutter {
  std::string key;  ///< in the input
  plane::Loop loop;
};

/// The polygon with counter-clockwise orientation.
Polygon turned_left(Polygon polygon) {
  if (plane::signed_area(polygon) < 0) std::ranges::reverse(polygon);
  return polygon;
}

/// The best mean-ratio quality of a tetrahedron in a wedge of this angle, with two corners on its edge.
double best_quality(double angle) {
  if (angle >= std::numbers::pi / 3) return 1;
  const double half = std::sin(angle / 2);
  const double square = 1 + half * half;  // squared edge length relative to the legs
  return 2 * std::pow(std::sin(angle) / 2, 2.0 / 3) * std::pow(square, -2.0 / 3);
}

struct Ellipse {
  Point centre, first, second;  ///< centre + cos(angle) first + sin(angle) second
};

/// Points where a region's limits of y or z cross an ellipse, within its limits of the other coordinate. Uses
/// only square roots, like plane::arc.
Polygon limits_on(const Ellipse& curve, const Region& region) {
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

/// Inserts a point of a curve as a corner of its polygon: it replaces a corner closer than this share of the
/// chord, unless that one must stay.
constexpr double replacing_share = 0.25;
/// Points of a curve closer than this share of a chord are identical.
constexpr double same_share = 1e-6;

void set_corner(Polygon& corners, const Point& p, const Polygon& stays) {
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

class ShapeMaker {
public:
  ShapeMaker(const Parameters& parameters, Findings& findings)
      : parameters_(parameters), specimen_(parameters.specimen), findings_(findings), spacing_(parameters) {}

  std::optional<plane::Shape> make() {
    if (!add_outline() || !check_chords("specimen.outline", shape_.loops.front().corners)) return {};
    size_ = 0;
    for (const Point& p : shape_.loops.front().corners)
      for (const Point& q : shape_.loops.front().corners) size_ = std::max(size_, plane::norm(p - q));
    std::vector<Cutter> cutters;
    for (std::size_t i = 0; i < specimen_.holes.size(); ++i)
      if (auto loop = hole(i)) cutters.push_back({fmt::format("specimen.hole[{}]", i), std::move(*loop)});
    for (std::size_t i = 0; i < specimen_.notches.size(); ++i)
      if (auto loop = notch(i)) cutters.push_back({fmt::format("specimen.notch[{}]", i), std::move(*loop)});
    for (std::size_t i = 0; i < cutters.size(); ++i) {
      if (!check_chords(cutters[i].key, cutters[i].loop.corners)) return {};
      if (!is_apart(cutters, i)) return {};
      if (!cut(cutters[i])) return {};
    }
    if (findings_.faulty("specimen")) return {};
    if (!check_gaps() || !check_corners()) return {};
    return std::move(shape_);
  }

private:
  int add_part(std::string name, bool is_curve) {
    shape_.parts.push_back({std::move(name), is_curve});
    return static_cast<int>(shape_.parts.size()) - 1;
  }

  /// A closed curve whose chords end at the limits of condition regions on it.
  Polygon ellipse(const Ellipse& curve, const std::string& name) const {
    Polygon corners = plane::arc(curve.centre, curve.first, curve.second, 4, spacing_);
    Polygon stays;
    // The extent of a circle along y and z determines that of the body.
    if (name.starts_with("edge"))
      stays = {curve.centre + curve.first, curve.centre + curve.second, curve.centre - curve.first,
               curve.centre - curve.second};
    for (const Boundary& condition : parameters_.boundaries) {
      if (condition.on != name) continue;
      for (const Point& limit : limits_on(curve, condition.region)) {
        set_corner(corners, limit, stays);
        stays.push_back(limit);
      }
    }
    return corners;
  }

  bool add_outline() {
    plane::Loop loop;
    if (!specimen_.outline) {
      const Vector& size = specimen_.size;
      loop.corners = {{0, 0}, {size[1], 0}, {size[1], size[2]}, {0, size[2]}};
    } else if (specimen_.outline->polygon.empty()) {
      const double radius = specimen_.outline->radius;
      loop.corners = ellipse({{radius, radius}, {radius, 0}, {0, radius}}, "edge-0");
      loop.part.assign(loop.size(), add_part("edge-0", true));
    } else {
      loop.corners = specimen_.outline->polygon;
      if (!plane::is_simple(loop.corners)) {
        findings_.report("specimen.outline",
                         "the polygon intersects itself; give its corners in order, each once");
        return false;
      }
    }
    if (loop.part.empty())
      for (std::size_t i = 0; i < loop.size(); ++i)
        loop.part.push_back(add_part(fmt::format("edge-{}", i), false));
    if (plane::signed_area(loop.corners) < 0) {
      // Side i, from corner i to the next one, is now the side that leads to corner i.
      std::ranges::reverse(loop.corners);
      std::ranges::reverse(loop.part);
      std::rotate(loop.part.begin(), loop.part.begin() + 1, loop.part.end());
    }
    shape_.loops = {std::move(loop)};
    return true;
  }

  plane::Loop of_part(Polygon polygon, int part) const {
    plane::Loop loop{turned_left(std::move(polygon)), {}};
    loop.part.assign(loop.size(), part);
    return loop;
  }

  bool check_chords(const std::string& key, const Polygon& corners) {
    if (static_cast<double>(corners.size()) < 2 * plane::max_chords) return true;
    findings_.report(key, "needs more than {} chords at the spacing there; give a coarser spacing",
                     corners.size());
    return false;
  }

  std::optional<plane::Loop> hole(std::size_t i) {
    const Hole& given = specimen_.holes[i];
    const std::string key = fmt::format("specimen.hole[{}]", i);
    const int part = add_part(fmt::format("hole-{}", i), given.polygon.empty());
    if (findings_.faulty(key)) return {};
    if (!given.polygon.empty()) {
      if (!plane::is_simple(given.polygon)) {
        findings_.report(key + ".polygon",
                         "the polygon intersects itself; give its corners in order, each once");
        return {};
      }
      return of_part(given.polygon, part);
    }
    const Point along{std::cos(given.angle), std::sin(given.angle)};
    return of_part(ellipse({given.center, given.semi_axes[0] * along, given.semi_axes[1] * left_of(along)},
                           fmt::format("hole-{}", i)),
                   part);
  }

  std::optional<plane::Loop> notch(std::size_t i) {
    const Notch& given = specimen_.notches[i];
    const std::string key = fmt::format("specimen.notch[{}]", i);

    const int part = add_part(fmt::format("notch-{}", i), false);
    if (findings_.faulty(key)) return {};
    if (!given.slot) return of_part(in_face(given), part);
    const auto polygon = between_points(given, key);
    if (!polygon) return {};
    return of_part(*polygon, part);
  }

  /// A slot cut into a face of the box or of the bounding box of the outline.
  Polygon in_face(const Notch& given) const {
    const plane::Bounds bounds = plane::bounds_of(shape_.loops.front().corners);
    const std::size_t depth_axis = index(axis_of(given.face)) - 1;
    const std::size_t at_axis = index(position_axis(given.face)) - 1;
    const double mouth = is_upper(given.face) ? bounds.upper[depth_axis] : bounds.lower[depth_axis];
    const double tip = is_upper(given.face) ? mouth - given.depth : mouth + given.depth;
    Polygon polygon;
    for (const auto& [side, depth] : {std::pair{-1, mouth}, {-1, tip}, {1, tip}, {1, mouth}}) {
      Point p{};
      p[at_axis] = given.at + side * given.height / 2;
      p[depth_axis] = depth;
      polygon.push_back(p);
    }
    return polygon;
  }

  bool is_in_body(const Point& p) const {
    const Polygon& outline = shape_.loops.front().corners;
    for (std::size_t i = 0; i < outline.size(); ++i)
      if (plane::distance(p, outline[i], outline[(i + 1) % outline.size()]) <= on_surface * size_)
        return false;
    return plane::holds(outline, p);
  }

  /// The corners at one end of a slot, from the right of its direction to the left.
  /// @param direction unit vector out of the slot
  Polygon slot_end(const Notch& given, Point end, const Point& direction) const {
    const Point left = given.height / 2 * left_of(direction);
    if (is_in_body(end)) {
      if (given.slot->end == SlotEnd::square) return {end - left, end + left};
      return plane::arc(end - given.height / 2 * direction, -1.0 * left, given.height / 2 * direction, 2,
                        spacing_);
    }
    // An open end is extended until it is outside over its whole height, and slightly beyond.
    const Point step = given.height / 8 * direction;
    for (int i = 0; i < 64 && (is_in_body(end - left) || is_in_body(end + left)); ++i) end = end + step;
    end = end + step;
    return {end - left, end + left};
  }

  std::optional<Polygon> between_points(const Notch& given, const std::string& key) {
    const auto& [from, to, end] = *given.slot;
    const double length = plane::norm(to - from);
    if (!(length > touching * size_)) {
      findings_.report(key + ".to", "is the same point as from; give two different points");
      return {};
    }
    const bool is_inside = is_in_body(from) && is_in_body(to);
    if (end == SlotEnd::round && length + touching * size_ < (is_inside ? 2 : 1) * given.height / 2) {
      findings_.report(
          key + ".height", "{} is too high for a slot of length {} with round ends; give at most {}",
          input::show(given.height), input::show(length), input::show(length * (is_inside ? 1 : 2)));
      return {};
    }
    const Point direction = direction_of(to - from);
    Polygon polygon = slot_end(given, to, direction);
    for (const Point& p : slot_end(given, from, -1.0 * direction))
      // The half circles of a slot as long as it is high share their ends.
      if (p != polygon.back() && p != polygon.front()) polygon.push_back(p);
    return polygon;
  }

  bool is_apart(const std::vector<Cutter>& cutters, std::size_t i) {
    const Polygon& a = cutters[i].loop.corners;
    for (std::size_t j = 0; j < i; ++j) {
      const Polygon& b = cutters[j].loop.corners;
      if (!plane::come_near(a, b, touching * size_) && !plane::holds(a, b[0]) && !plane::holds(b, a[0]))
        continue;
      findings_.report(cutters[i].key, "touches or overlaps {}; leave material between them", cutters[j].key);
      return false;
    }
    return true;
  }

  /// Cuts out a figure inside the outline and separate from all others, which needs no set operation.
  bool cut_hole(const Cutter& cutter) {
    const Polygon& corners = cutter.loop.corners;
    const Polygon& outline = shape_.loops.front().corners;
    if (plane::come_near(corners, outline, touching * size_) || !plane::holds(outline, corners[0]))
      return false;
    plane::Loop hole = cutter.loop;
    std::ranges::reverse(hole.corners);  // all sides belong to one part
    shape_.loops.push_back(std::move(hole));
    return true;
  }

  bool cut(const Cutter& cutter) {
    if (cut_hole(cutter)) return true;
    const double before = plane::area(shape_);
    std::vector<plane::Shape> pieces = plane::difference(shape_, cutter.loop);
    std::erase_if(pieces, [&](const plane::Shape& piece) {
      return plane::area(piece) <= touching * touching * size_ * size_;
    });
    const bool is_hole = cutter.key.starts_with("specimen.hole");
    if (pieces.empty()) {
      findings_.report(cutter.key, "leaves nothing of the body");
    } else if (pieces.size() > 1) {
      findings_.report(cutter.key, "cuts the body into {} pieces; leave it in one piece",
                       pieces.size() == 2 ? "two" : fmt::format("{}", pieces.size()));
    } else if (plane::area(pieces[0]) >= before * (1 - touching * touching)) {
      findings_.report(cutter.key, "lies outside the body; give positions between {} and {}",
                       show_place(plane::bounds_of(shape_.loops.front().corners).lower),
                       show_place(plane::bounds_of(shape_.loops.front().corners).upper));
    } else if (is_hole && pieces[0].loops.size() != shape_.loops.size() + 1) {
      findings_.report(
          cutter.key,
          "crosses the edge of the body; leave material around it, or make it part of the outline");
    } else {
      shape_ = std::move(pieces[0]);
      return true;
    }
    return false;
  }

  std::string key_of(int part) const {
    const std::string& name = shape_.parts[static_cast<std::size_t>(part)].name;
    const std::size_t dash = name.find('-');
    const std::string kind = name.substr(0, dash);
    if (kind == "edge") return specimen_.outline ? "specimen.outline" : "specimen.size";
    return fmt::format("specimen.{}[{}]", kind, name.substr(dash + 1));
  }

  bool check_gaps() {
    const auto gap = plane::smallest_gap(shape_, touching * size_);
    if (!gap) return true;
    const int one = shape_.loops[gap->loop].part[gap->side];
    const int other = shape_.loops[gap->other_loop].part[gap->other_side];
    findings_.report(key_of(std::max(one, other)), "{} is only {} from {} at {}; leave more than {}",
                     shape_.parts[static_cast<std::size_t>(std::max(one, other))].name,
                     input::show(gap->distance),
                     shape_.parts[static_cast<std::size_t>(std::min(one, other))].name,
                     show_place(shape_.loops[gap->loop].from(gap->side)), input::show(touching * size_));
    return false;
  }

  bool check_corners() {
    if (findings_.faulty("mesh.min_quality")) return true;
    const plane::Corner corner = plane::sharpest_corner(shape_);
    const double best = best_quality(corner.angle);
    if (best >= quality_reserve * parameters_.mesh.min_quality) return true;
    findings_.report("mesh.min_quality",
                     "the corner of the body at {} has {:.3g} degrees, which limits the quality there to "
                     "{:.2g}; give at most {:.2g}, or a blunter corner",
                     show_place(corner.place), corner.angle * 180 / std::numbers::pi, best,
                     best / quality_reserve);
    return false;
  }

  const Parameters& parameters_;
  const Specimen& specimen_;
  Findings& findings_;
  MeshSpacing spacing_;
  plane::Shape shape_;
  double size_ = 0;  ///< largest distance of two corners [m]
};

/// Checks between the keys of one table.
void check_holes(const Parameters& parameters, Findings& findings) {
  for (std::size_t i = 0; i < parameters.specimen.holes.size(); ++i) {
    const std::string key = fmt::format("specimen.hole[{}]", i);
    const auto given = [&](const char* name) { return findings.given(key + "." + name); };
    const int n_given = given("radius") + given("semi_axes") + given("polygon");
    if (n_given != 1) {
      findings.report(key, n_given == 0 ? "has no shape; give one of radius, semi_axes and polygon"
                                        : "has several shapes; give one of radius, semi_axes and polygon");
      continue;
    }
    if (given("polygon") && given("center"))
      findings.report(key + ".center", "cannot be combined with polygon; leave it out");
    if (!given("polygon") && !given("center"))
      findings.report(key + ".center",
                      "the key is missing; give two lengths, y and z, such as [\"5 mm\", \"8 mm\"]");
    if (given("angle") && !given("semi_axes"))
      findings.report(key + ".angle", "applies to semi_axes only; leave it out");
  }
}

void check_slots(const Parameters& parameters, Findings& findings) {
  for (std::size_t i = 0; i < parameters.specimen.notches.size(); ++i) {
    const std::string key = fmt::format("specimen.notch[{}]", i);
    const auto given = [&](const char* name) { return findings.given(key + "." + name); };
    if (!given("from")) {
      for (const char* name : {"to", "end"})
        if (given(name))
          findings.report(fmt::format("{}.{}", key, name),
                          "applies to a slot between two points only; give from too, or leave it out");
      continue;
    }
    if (!given("to"))
      findings.report(key + ".to",
                      "the key is missing; give two lengths, y and z, such as [\"5 mm\", \"8 mm\"]");
    for (const char* name : {"face", "at", "depth"})
      if (given(name))
        findings.report(fmt::format("{}.{}", key, name), "cannot be combined with from and to; leave it out");
  }
}

void check_outline(const Parameters& parameters, Findings& findings) {
  const auto& outline = parameters.specimen.outline;
  const bool is_given = findings.given("specimen.outline");
  if (!is_given) {
    for (const char* name : {"thickness", "radius"})
      if (findings.given(fmt::format("specimen.{}", name)))
        findings.report(fmt::format("specimen.{}", name), "requires outline; give outline, or size alone");
    return;
  }
  if (findings.given("specimen.size"))
    findings.report("specimen.size",
                    "is given together with outline; give either size, or thickness and outline");
  if (!findings.given("specimen.thickness"))
    findings.report("specimen.thickness", "the key is missing; give a length such as \"5 mm\"");
  if (findings.faulty("specimen.outline")) return;
  const bool is_circle = outline->polygon.empty();
  if (is_circle && !findings.given("specimen.radius"))
    findings.report("specimen.radius",
                    "the key is missing, but outline = \"circle\" requires it; give a length such as "
                    "\"25 mm\"");
  if (!is_circle && findings.given("specimen.radius"))
    findings.report("specimen.radius", "applies to outline = \"circle\" only; leave it out");
}

}  // namespace

bool size_is_known(const Findings& findings) {
  return std::ranges::none_of(std::array{"size", "thickness", "outline", "radius"}, [&](const char* key) {
    return findings.faulty(fmt::format("specimen.{}", key));
  });
}

bool shape_is_known(const Specimen& specimen, const Findings& findings) {
  return !findings.faulty("specimen") && (is_box(specimen) || specimen.shape);
}

Region bounds_of(const Specimen& specimen) {
  Region bounds;
  for (std::size_t i = 0; i < 3; ++i) bounds[i] = {0, specimen.size[i]};
  if (specimen.outline && !specimen.outline->polygon.empty()) {
    const plane::Bounds plane = plane::bounds_of(specimen.outline->polygon);
    for (std::size_t i = 0; i < 2; ++i) bounds[i + 1] = {plane.lower[i], plane.upper[i]};
  }
  return bounds;
}

void complete_specimen(Parameters& parameters, Findings& findings) {
  check_outline(parameters, findings);
  check_holes(parameters, findings);
  check_slots(parameters, findings);
  Specimen& specimen = parameters.specimen;
  if (specimen.outline && size_is_known(findings)) {
    specimen.size[1] = specimen.size[2] = 2 * specimen.outline->radius;
    const Region bounds = bounds_of(specimen);
    for (std::size_t i = 1; i < 3; ++i) specimen.size[i] = bounds[i].second - bounds[i].first;
  }
  const bool has_spacing = !findings.faulty("mesh.spacing") && !findings.faulty("mesh.notch_spacing") &&
                           !findings.faulty("mesh.growth") && !findings.faulty("mesh.region");
  if (is_box(specimen) || !has_spacing || findings.faulty("specimen") || !(parameters.mesh.spacing > 0))
    return;
  specimen.shape = ShapeMaker(parameters, findings).make();
}

}  // namespace crackle::input
