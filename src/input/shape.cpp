// SPDX-License-Identifier: GPL-3.0-or-later
// The shape of the body in the plane of the plate.
#include "common/known_values.h"
#include "consistency.h"
#include "dimension.h"
#include "figures.h"
#include "plane/subdivision.h"
#include "solid_checks.h"

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
/// Coordinates this close, relative to the body's size, are equal up to rounding.
constexpr double rounding = 1e-13;

using plane::Point;
using plane::Polygon;
using plane::operator+;
using plane::operator-;
using plane::operator*;

/// A figure cut out of the outline.
struct Cutter {
  std::string key;  ///< in the input
  plane::Loop loop;
  bool is_curve = false;
  bool meets = false;  ///< one of those before it
};

class ShapeMaker {
public:
  ShapeMaker(const Parameters& parameters, Findings& findings)
      : parameters_(parameters), specimen_(parameters.specimen), findings_(findings), figures_(parameters) {}

  std::optional<plane::Shape> make() {
    if (!add_outline() || !check_chords("specimen.outline", shape_.loops.front().corners, findings_))
      return {};
    size_ = 0;
    for (const Point& p : shape_.loops.front().corners)
      for (const Point& q : shape_.loops.front().corners) size_ = std::max(size_, plane::norm(p - q));
    outline_ = shape_.loops.front().corners;
    std::vector<Cutter> cutters;
    for (std::size_t i = 0; i < specimen_.holes.size(); ++i)
      if (auto loop = hole(i))
        cutters.push_back(
            {fmt::format("specimen.hole[{}]", i), std::move(*loop), specimen_.holes[i].polygon.empty()});
    for (std::size_t i = 0; i < specimen_.notches.size(); ++i)
      if (auto loop = notch(i)) cutters.push_back({fmt::format("specimen.notch[{}]", i), std::move(*loop)});
    for (Cutter& cutter : cutters)
      if (cutter.is_curve) end_chords_at(cutters, cutter);
    for (std::size_t i = 0; i < cutters.size(); ++i) {
      if (!check_chords(cutters[i].key, cutters[i].loop.corners, findings_)) return {};
      if (!can_meet(cutters, i)) return {};
      if (!cut(cutters[i])) return {};
    }
    if (findings_.faulty("specimen")) return {};
    if (std::ranges::any_of(cutters, &Cutter::meets)) align_corners();
    if (!check_walls(cutters) || !check_gaps() || !check_corners()) return {};
    return std::move(shape_);
  }

private:
  int add_part(std::string name, bool is_curve) {
    shape_.parts.push_back({std::move(name), is_curve});
    return static_cast<int>(shape_.parts.size()) - 1;
  }

  bool add_outline() {
    plane::Loop loop;
    if (!specimen_.outline) {
      const Vector& size = specimen_.size;
      loop.corners = {{0, 0}, {size[1], 0}, {size[1], size[2]}, {0, size[2]}};
    } else if (specimen_.outline->polygon.empty()) {
      const double radius = specimen_.outline->radius;
      loop.corners = figures_.ellipse({{radius, radius}, {radius, 0}, {0, radius}}, "edge-0");
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
    plane::Loop loop{counter_clockwise(std::move(polygon)), {}};
    loop.part.assign(loop.size(), part);
    return loop;
  }

  std::optional<plane::Loop> hole(std::size_t i) {
    const plane::Hole& given = specimen_.holes[i];
    const std::string key = fmt::format("specimen.hole[{}]", i);
    const std::string name = fmt::format("hole-{}", i);
    const int part = add_part(name, given.polygon.empty());
    auto corners = figures_.outline(given, key, name, findings_);
    if (!corners) return {};
    return of_part(std::move(*corners), part);
  }

  std::optional<plane::Loop> notch(std::size_t i) {
    const plane::Notch& given = specimen_.notches[i];
    const std::string key = fmt::format("specimen.notch[{}]", i);

    const int part = add_part(fmt::format("notch-{}", i), false);
    if (findings_.faulty(key)) return {};
    if (!given.slot) return of_part(in_face(given), part);
    const auto polygon = between_points(given, key);
    if (!polygon) return {};
    return of_part(*polygon, part);
  }

  /// A slot cut into a face of the box or of the bounding box of the outline.
  Polygon in_face(const plane::Notch& given) const {
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

  static double distance_to(const Polygon& polygon, const Point& p) {
    double nearest = infinity;
    for (std::size_t i = 0; i < polygon.size(); ++i)
      nearest = std::min(nearest, plane::distance(p, polygon[i], polygon[(i + 1) % polygon.size()]));
    return nearest;
  }

  /// True in a hole and on its border.
  bool is_in_hole(const Point& p) const {
    return std::ranges::any_of(specimen_.holes, [&](const plane::Hole& hole) {
      if (!hole.polygon.empty())
        return plane::holds(hole.polygon, p) || distance_to(hole.polygon, p) <= on_surface * size_;
      const Point along{std::cos(hole.angle), std::sin(hole.angle)};
      const Point offset = p - hole.center;
      return plane::norm({plane::dot(offset, along) / hole.semi_axes[0],
                          plane::cross(along, offset) / hole.semi_axes[1]}) <= 1 + on_surface;
    });
  }

  bool is_in_outline(const Point& p) const {
    return plane::holds(outline_, p) && distance_to(outline_, p) > on_surface * size_;
  }
  bool is_in_body(const Point& p) const { return is_in_outline(p) && !is_in_hole(p); }

  /// The corners at one end of a slot, from the right of its direction to the left.
  /// @param direction unit vector out of the slot
  Polygon slot_end(const plane::Notch& given, Point end, const Point& direction) const {
    const Point left = given.height / 2 * left_of(direction);
    if (is_in_outline(end)) {
      if (const auto open = end_in_hole(given, end, direction)) return *open;
      if (given.slot->end == plane::SlotEnd::square) return {end - left, end + left};
      return plane::arc(end - given.height / 2 * direction, -1.0 * left, given.height / 2 * direction, 2,
                        figures_.spacing());
    }
    // An open end is extended until it is outside over its whole height, and slightly beyond.
    const Point step = given.height / 8 * direction;
    for (int i = 0; i < 64 && (is_in_outline(end - left) || is_in_outline(end + left)); ++i) end = end + step;
    end = end + step;
    return {end - left, end + left};
  }

  /// The same of an end in a hole: it is extended until it is in the hole over its whole height.
  std::optional<Polygon> end_in_hole(const plane::Notch& given, Point end, const Point& direction) const {
    const Point left = given.height / 2 * left_of(direction);
    for (; is_in_hole(end); end = end + given.height / 8 * direction)
      if (is_in_hole(end - left) && is_in_hole(end + left)) return Polygon{end - left, end + left};
    return {};
  }

  std::optional<Polygon> between_points(const plane::Notch& given, const std::string& key) {
    const auto& [from, to, end] = *given.slot;
    const double length = plane::norm(to - from);
    if (!(length > touching * size_)) {
      findings_.report(key + ".to", "is the same point as from; give two different points");
      return {};
    }
    const bool is_inside = is_in_body(from) && is_in_body(to);
    if (end == plane::SlotEnd::round && length + touching * size_ < (is_inside ? 2 : 1) * given.height / 2) {
      findings_.report(
          key + ".height", "{} is too high for a slot of length {} with round ends; give at most {}",
          input::show(given.height), input::show(length), input::show(length * (is_inside ? 1 : 2)));
      return {};
    }
    const Point direction = 1 / length * (to - from);
    Polygon polygon = slot_end(given, to, direction);
    for (const Point& p : slot_end(given, from, -1.0 * direction))
      // The half circles of a slot as long as it is high share their ends.
      if (p != polygon.back() && p != polygon.front()) polygon.push_back(p);
    return polygon;
  }

  /// Makes chords of a curve end where it meets other figures, so that none is short.
  static void end_chords_at(const std::vector<Cutter>& cutters, Cutter& curve) {
    Polygon stays;
    for (const Cutter& other : cutters) {
      if (&other == &curve) continue;
      for (const Point& place : intersections(curve.loop.corners, other.loop.corners)) {
        insert_vertex(curve.loop.corners, place, stays);
        stays.push_back(place);
      }
    }
    curve.loop.part.resize(curve.loop.size(), curve.loop.part.front());
  }

  /// Figures may overlap, but not just touch.
  bool can_meet(std::vector<Cutter>& cutters, std::size_t i) {
    const Polygon& a = cutters[i].loop.corners;
    for (std::size_t j = 0; j < i; ++j) {
      const Polygon& b = cutters[j].loop.corners;
      if (!plane::come_near(a, b, touching * size_) && !plane::holds(a, b[0]) && !plane::holds(b, a[0]))
        continue;
      cutters[i].meets = true;
      if (plane::common_area({{{a, cutters[i].loop.part}}, {}}, b) > touching * size_ * size_) continue;
      findings_.report(cutters[i].key, "touches {}; let them overlap, or leave material between them",
                       cutters[j].key);
      return false;
    }
    return true;
  }

  /// Makes coordinates equal that differ by rounding, so that walls of several figures in one plane are so.
  void align_corners() {
    std::array<KnownValues, 2> known;
    for (const Point& p : outline_)
      for (std::size_t i = 0; i < 2; ++i) known[i].insert(p[i]);
    for (plane::Loop& loop : shape_.loops)
      for (Point& p : loop.corners)
        for (std::size_t i = 0; i < 2; ++i) p[i] = known[i].aligned(p[i], rounding * size_);
  }

  /// Every figure has a wall, which its name stands for.
  bool check_walls(const std::vector<Cutter>& cutters) {
    for (const Cutter& cutter : cutters)
      if (std::ranges::none_of(shape_.loops, [&](const plane::Loop& loop) {
            return std::ranges::find(loop.part, cutter.loop.part.front()) != loop.part.end();
          })) {
        findings_.report(cutter.key, "lies in other holes or notches; leave it out");
        return false;
      }
    return true;
  }

  /// Cuts out a figure inside the outline and separate from all others, which needs no set operation.
  bool cut_hole(const Cutter& cutter) {
    if (cutter.meets) return false;
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
    } else if (cutter.meets && plane::area(pieces[0]) >= before * (1 - touching * touching)) {
      findings_.report(cutter.key, "lies in other holes or notches; leave it out");
    } else if (plane::area(pieces[0]) >= before * (1 - touching * touching)) {
      findings_.report(cutter.key, "lies outside the body; give positions between {} and {}",
                       show_place(plane::bounds_of(shape_.loops.front().corners).lower),
                       show_place(plane::bounds_of(shape_.loops.front().corners).upper));
    } else if (is_hole && plane::come_near(cutter.loop.corners, outline_, touching * size_)) {
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
    const plane::Corner corner = plane::sharpest_corner(shape_);
    return check_corner(corner, fmt::format("the corner of the body at {}", show_place(corner.place)),
                        parameters_, findings_);
  }

  const Parameters& parameters_;
  const plane::Specimen& specimen_;
  Findings& findings_;
  ShapeBuilder figures_;
  plane::Shape shape_;
  Polygon outline_;  ///< before anything is cut out
  double size_ = 0;  ///< largest distance of two corners [m]
};

void check_holes(const Parameters& parameters, Findings& findings) {
  for (std::size_t i = 0; i < parameters.specimen.holes.size(); ++i)
    check_figure(fmt::format("specimen.hole[{}]", i), findings);
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

/// @pre is_box(specimen)
bool has_meeting_notches(const plane::Specimen& specimen) {
  const Vector& size = specimen.size;
  const plane::Region bounds = bounds_of(specimen);
  const Vector near{touching * size[0], touching * size[1], touching * size[2]};
  for (std::size_t i = 0; i < specimen.notches.size(); ++i)
    for (std::size_t j = 0; j < i; ++j)
      if (plane::meet(slot_of(specimen.notches[i], bounds), slot_of(specimen.notches[j], bounds), near))
        return true;
  return false;
}

}  // namespace

bool size_is_known(const Findings& findings) {
  return std::ranges::none_of(
      std::array{"size", "thickness", "outline", "radius", "solid", "unit"},
      [&](const char* key) { return findings.faulty(fmt::format("specimen.{}", key)); });
}

bool shape_is_known(const plane::Specimen& specimen, const Findings& findings) {
  return !findings.faulty("specimen") && (is_box(specimen) || specimen.shape || specimen.solid);
}

void complete_specimen(Parameters& parameters, Findings& findings) {
  complete_solid(parameters, findings);
  if (findings.given("specimen.solid")) return check_solid(parameters, findings);
  check_outline(parameters, findings);
  check_holes(parameters, findings);
  check_slots(parameters, findings);
  plane::Specimen& specimen = parameters.specimen;
  if (specimen.outline && size_is_known(findings)) {
    specimen.size[1] = specimen.size[2] = 2 * specimen.outline->radius;
    const plane::Region bounds = bounds_of(specimen);
    for (std::size_t i = 1; i < 3; ++i) specimen.size[i] = bounds[i].second - bounds[i].first;
  }
  make_region_outlines(parameters, findings);
  specimen.shape.reset();
  if (!has_spacing(parameters, findings) || findings.faulty("specimen")) return;
  if (is_box(specimen) && !has_meeting_notches(specimen)) return;
  specimen.shape = ShapeMaker(parameters, findings).make();
}

}  // namespace crackle::input
