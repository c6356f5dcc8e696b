// SPDX-License-Identifier: GPL-3.0-or-later
#include "imprint.h"

#include "common/failure.h"
#include "common/index.h"
#include "common/known_values.h"
#include "geometry/mother_points.h"

#include "tolerances.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <deque>
#include <map>
#include <optional>
#include <set>
#include <tuple>
#include <utility>

namespace crackle::geometry {

namespace {

/// Maximum number of pieces of a line for measuring its distance to others.
constexpr double most_pieces = 1000;

/// A straight piece of a border between two corners, or one corner within a face.
struct BorderLine {
  std::array<Point, 2> end;
  std::size_t condition;  ///< whose border it is
};
using Imprints = std::map<FaceId, std::vector<BorderLine>>;

/// The lines that require a finer mesh than the rest: where others come close.
void add_line_sources(const Imprints& imprints, const Body& body, const input::Mesh& mesh,
                      std::vector<SpacingSource>& sources) {
  const SpacingField without(body.bounds(), mesh, sources);
  const double tolerance = wall_tolerance * std::ranges::max(body.size());
  for (const auto& [id, lines] : imprints) {
    const Face& face = body.faces()[index(id)];
    const auto axes = face.spanning_axes();
    const auto own = [&](const Point& p) {
      const Point full = face.patch.own(p);
      return plane::Point{full[axes[0]], full[axes[1]]};
    };
    std::vector<std::array<plane::Point, 2>> others;
    for (const Edge& edge : body.edges())
      if (body.in_face(id, edge.from()) && body.in_face(id, edge.to()))
        others.push_back({own(edge.from()), own(edge.to())});
    for (const BorderLine& line : lines) {
      const std::array own_line{own(line.end[0]), own(line.end[1])};
      const double length = norm(line.end[1] - line.end[0]);
      const double n_pieces = std::clamp(std::ceil(length / mesh.spacing), 1.0, most_pieces);
      for (double piece = 0; piece < n_pieces; ++piece) {
        const auto at = [](double share, const auto& end) {
          auto p = end[0];
          for (std::size_t i = 0; i < p.size(); ++i) p[i] += share * (end[1][i] - end[0][i]);
          return p;
        };
        const double first = piece / n_pieces;
        const double last = (piece + 1) / n_pieces;
        const std::array own_piece{at(first, own_line), at(last, own_line)};
        double gap = length > 0 ? length : mesh.spacing;
        for (const auto& other : others) {
          const bool touches = std::ranges::any_of(other, [&](const plane::Point& p) {
            return plane::distance(p, own_line[0], own_line[1]) <= tolerance;
          });
          if (!touches) gap = std::min(gap, plane::distance(own_piece[0], own_piece[1], other[0], other[1]));
        }
        if (!(gap * fine_enough < without(at((first + last) / 2, line.end)))) continue;
        Box region{at(first, line.end), at(first, line.end)};
        region.include(at(last, line.end));
        sources.push_back({region,
                           gap,
                           shape_growth(mesh),
                           fmt::format("the region of boundary[{}]", line.condition),
                           {},
                           static_cast<int>(line.condition)});
      }
    }
  }
}

/// Makes corners, edges and lines from the borders of regions.
class Imprinting {
public:
  Imprinting(const Body& plain, std::span<const ConditionRegion> regions)
      : plain_(plain),
        tolerance_(wall_tolerance * std::ranges::max(plain.size())),
        merging_(merging_share * std::ranges::max(plain.size())) {
    for (const Point& corner : plain_.corners()) corners_.push_back(corner);
    n_plain_ = corners_.size();
    collect_known_coordinates();
    for (std::size_t i = 0; i < regions.size(); ++i) {
      bool has_material = false;
      for (const FacePart& part : regions[i].parts) has_material = add(part, i) || has_material;
      if (!has_material) refuse(i, regions[i].parts.front());
    }
    for (std::size_t i = 0; i < borders_.size(); ++i)
      for (std::size_t j = 0; j < i; ++j) add_crossing(borders_[i], borders_[j]);
  }

  Complex result() {
    for (const Edge& edge : plain_.edges()) {
      Point from = edge.from();
      for (const std::size_t i : corners_on(edge.from(), edge.to(), n_plain_)) {
        edges_.emplace_back(from, corners_[i]);
        from = corners_[i];
      }
      edges_.emplace_back(from, edge.to());
    }
    for (const Border& border : borders_) add_lines(border);
    for (const auto& [i, part, condition] : isolated_)
      if (made_.emplace(part->face, i, i).second)
        imprints_[part->face].push_back({{corners_[i], corners_[i]}, condition});
    Complex complex = plain_.complex();
    complex.corners = std::move(corners_);
    complex.edges = std::move(edges_);
    complex.spacing_rules.push_back([imprints = std::move(imprints_)](const Body& body,
                                                                      const input::Mesh& mesh,
                                                                      std::vector<SpacingSource>& sources) {
      add_line_sources(imprints, body, mesh, sources);
    });
    return complex;
  }

private:
  /// A border as requested by a region, before it is split by others: own coordinate `across` equals
  /// `position`.
  struct Border {
    const FacePart* part;
    const FacePart* frame;  ///< whose own axes are along and across it: the part, or one turned in its plane
    std::size_t condition;
    std::size_t across;
    double position;
    double from, to;  ///< along the other own coordinate
  };

  static plane::Point place_on(const Border& border, double along) {
    return border.across == 0 ? plane::Point{border.position, along} : plane::Point{along, border.position};
  }

  /// The range of a line, position + t along, within the limits of a part; empty if there is none.
  static std::optional<std::pair<double, double>> range_within(const FacePart& part, const Point& position,
                                                               const Vector& along) {
    std::pair<double, double> range = plane::unbounded;
    for (std::size_t i = 0; i < 3; ++i) {
      if (!part.has_limit(i)) continue;
      const auto [first, last] = part.limits[i];
      if (std::abs(along[i]) < 1e-9) {
        if (position[i] < first - part.tolerance || position[i] > last + part.tolerance) return {};
        continue;
      }
      const auto [enters, leaves] =
          std::minmax({(first - position[i]) / along[i], (last - position[i]) / along[i]});
      range = {std::max(range.first, enters), std::min(range.second, leaves)};
    }
    if (range.first > range.second) return {};
    return range;
  }

  /// The borders of a part with limits, each in a frame of its own.
  std::vector<Border> borders_at_limits(const FacePart& part, std::size_t condition) {
    std::vector<Border> borders;
    const Vector normal = cross(part.patch.axes[part.axis[0]], part.patch.axes[part.axis[1]]);
    for (std::size_t i = 0; i < 3; ++i) {
      Vector across = -normal[i] * normal;
      across[i] += 1;
      if (!part.has_limit(i) || norm(across) < 1e-6) continue;
      FacePart& frame = frames_.emplace_back(part);
      frame.axis = {0, 1};
      frame.patch.axes = {across / norm(across), cross(normal, across / norm(across)), normal};
      frame.patch.domain = {{}, {}};
      for (const double limit : std::set<double>{part.limits[i].first, part.limits[i].second}) {
        if (std::isinf(limit)) continue;
        const double position = (limit - part.patch.origin[i]) / frame.patch.axes[0][i];
        const auto range = range_within(part, frame.patch.at({position, 0, 0}), frame.patch.axes[1]);
        if (!range) continue;
        // Beyond the face the line has no end.
        const double beyond = 2 * norm(plain_.size()) + norm(part.patch.origin - plain_.bounds().lower);
        borders.push_back({&part, &frame, condition, 0, position, std::max(range->first, -beyond),
                           std::min(range->second, beyond)});
      }
    }
    return borders;
  }

  /// The borders of a part that lie within its face, and the ends of those on its outline.
  std::vector<Border> borders_of(const FacePart& part, std::size_t condition) {
    if (part.has_limits()) return borders_at_limits(part, condition);
    std::vector<Border> borders;
    for (std::size_t k = 0; k < 2; ++k) {
      const std::size_t axis = part.axis[k];
      std::set<double> positions{part.lower[k], part.upper[k]};
      positions.erase(part.patch.domain.lower[axis]);
      positions.erase(part.patch.domain.upper[axis]);
      for (const double position : positions)
        borders.push_back({&part, &part, condition, k, position, part.lower[1 - k], part.upper[1 - k]});
    }
    return borders;
  }

  /// Coordinates of planes that may contain corners, so that corners on different faces agree to the last
  /// bit.
  void collect_known_coordinates() {
    for (const Point& corner : plain_.corners())
      for (std::size_t i = 0; i < 3; ++i) known_[i].insert(corner[i]);
  }

  Point place(const FacePart& part, const plane::Point& own) {
    Point full = part.patch.domain.lower;
    for (std::size_t k = 0; k < 2; ++k) full[part.axis[k]] = own[k];
    Point p = part.patch.at(full);
    for (std::size_t i = 0; i < 3; ++i) p[i] = known_[i].aligned(p[i], tolerance_);
    return p;
  }

  std::size_t corner(const Point& p) {
    for (std::size_t i = 0; i < corners_.size(); ++i)
      if (norm(corners_[i] - p) <= merging_) return i;
    corners_.push_back(p);
    return corners_.size() - 1;
  }

  /// @return false if the part has nothing of its face, for example because of a hole
  bool add(const FacePart& part, std::size_t condition) {
    const std::size_t n_before = borders_.size();
    for (Border border : borders_of(part, condition)) {
      // Borders of other regions this close are the same line.
      for (const Border& other : borders_)
        if (!part.has_limits() && !other.part->has_limits() && other.part->face == part.face &&
            other.across == border.across && std::abs(other.position - border.position) <= merging_)
          border.position = other.position;
      add_clipped(border);
    }
    const bool has_ends = part.has_limits() ? add_ends_at_limits(part, condition) : add_ends(part, condition);
    return has_ends || borders_.size() > n_before ||
           std::ranges::any_of(plain_.corners(), [&](const Point& corner) {
             return plain_.in_face(part.face, corner) && part.contains(corner);
           });
  }

  [[noreturn]] void refuse(std::size_t condition, const FacePart& part) const {
    fail("boundary[{}]: its region contains no part of \"{}\"", condition,
         plain_.faces()[index(part.face)].names.front());
  }

  /// Adds the pieces of a border inside the face and off its outline.
  void add_clipped(const Border& border) {
    const FacePart& part = *border.frame;
    std::vector<double> cuts{border.from, border.to};
    for (const Edge& edge : plain_.edges()) {
      if (!plain_.in_face(part.face, edge.from()) || !plain_.in_face(part.face, edge.to())) continue;
      const plane::Point a = own(part, edge.from());
      const plane::Point b = own(part, edge.to());
      const double before = a[border.across] - border.position;
      const double after = b[border.across] - border.position;
      const std::size_t along = 1 - border.across;
      if (std::abs(before) <= merging_) cuts.push_back(a[along]);
      if (std::abs(after) <= merging_) cuts.push_back(b[along]);
      if ((before < -merging_ && after > merging_) || (before > merging_ && after < -merging_))
        cuts.push_back(a[along] + before / (before - after) * (b[along] - a[along]));
    }
    std::erase_if(cuts, [&](double cut) { return cut < border.from || cut > border.to; });
    std::ranges::sort(cuts);
    for (std::size_t i = 1; i < cuts.size(); ++i) {
      if (cuts[i] - cuts[i - 1] <= merging_) continue;
      const Point middle = place(part, place_on(border, (cuts[i - 1] + cuts[i]) / 2));
      if (!plain_.contains(middle) || !(plain_.distance_to_outline(part.face, middle) > merging_)) continue;
      Border piece = border;
      piece.from = cuts[i - 1];
      piece.to = cuts[i];
      for (const double end : {piece.from, piece.to}) corner(place(part, place_on(piece, end)));
      borders_.push_back(piece);
    }
  }

  /// Adds the corners of a part that end no border: those of a line on the face's outline, and points.
  /// @return true if there are any
  bool add_ends(const FacePart& part, std::size_t condition) {
    bool has_ends = false;
    for (const double first : {part.lower[0], part.upper[0]})
      for (const double second : {part.lower[1], part.upper[1]}) {
        const Point p = place(part, {first, second});
        if (!plain_.contains(p)) continue;
        has_ends = true;
        const std::size_t number = corner(p);
        if (part.n_dimensions() == 0 && plain_.distance_to_outline(part.face, p) > merging_)
          isolated_.emplace_back(number, &part, condition);
      }
    return has_ends;
  }

  /// The same for a part with limits.
  bool add_ends_at_limits(const FacePart& part, std::size_t condition) {
    bool has_ends = false;
    for (const Edge& edge : plain_.edges()) {
      if (!plain_.in_face(part.face, edge.from()) || !plain_.in_face(part.face, edge.to())) continue;
      const auto range = range_within(part, edge.from(), edge.direction());
      if (!range) continue;
      for (const double end : {range->first, range->second}) {
        if (end < -merging_ || end > edge.length() + merging_) continue;
        corner(edge.at(end));
        has_ends = true;
      }
    }
    if (part.n_dimensions() > 0) return has_ends;
    for (const Border& border : borders_at_limits(part, condition)) {
      const Point p = place(*border.frame, place_on(border, (border.from + border.to) / 2));
      if (!plain_.in_face(part.face, p)) continue;
      has_ends = true;
      const std::size_t number = corner(p);
      if (plain_.distance_to_outline(part.face, p) > merging_)
        isolated_.emplace_back(number, &part, condition);
    }
    return has_ends;
  }

  void add_crossing(const Border& a, const Border& b) {
    if (a.part->face != b.part->face) return;
    if (a.part->has_limits() || b.part->has_limits()) {
      const plane::Point from = own(*a.frame, place(*b.frame, place_on(b, b.from)));
      const plane::Point to = own(*a.frame, place(*b.frame, place_on(b, b.to)));
      const double before = from[a.across] - a.position, after = to[a.across] - a.position;
      if (!(before < 0) == !(after < 0)) return;
      const double along = plane::between(from, to, before / (before - after))[1 - a.across];
      if (along >= a.from - merging_ && along <= a.to + merging_) corner(place(*a.frame, place_on(a, along)));
      return;
    }
    if (a.across == b.across) return;
    if (b.position < a.from || b.position > a.to || a.position < b.from || a.position > b.to) return;
    corner(place(*a.part, place_on(a, b.position)));
  }

  plane::Point own(const FacePart& part, const Point& p) const {
    const Point full = part.patch.own(p);
    return {full[part.axis[0]], full[part.axis[1]]};
  }

  /// The corners from number `first` on that lie between two points, in order.
  std::vector<std::size_t> corners_on(const Point& from, const Point& to, std::size_t first) const {
    const double length = norm(to - from);
    const Vector along = (to - from) / length;
    std::vector<std::pair<double, std::size_t>> found;
    for (std::size_t i = first; i < corners_.size(); ++i) {
      const Vector offset = corners_[i] - from;
      const double arc_length = dot(offset, along);
      if (arc_length <= merging_ || arc_length >= length - merging_) continue;
      if (norm(offset - arc_length * along) <= merging_) found.emplace_back(arc_length, i);
    }
    std::ranges::sort(found);
    std::vector<std::size_t> numbers;
    for (const auto& [arc_length, i] : found) numbers.push_back(i);
    return numbers;
  }

  void add_lines(const Border& border) {
    const FacePart& part = *border.frame;
    const std::size_t first = corner(place(part, place_on(border, border.from)));
    const std::size_t last = corner(place(part, place_on(border, border.to)));
    std::vector<std::size_t> path = corners_on(corners_[first], corners_[last], 0);
    path.insert(path.begin(), first);
    path.push_back(last);
    for (std::size_t i = 1; i < path.size(); ++i) {
      const auto [low, high] = std::minmax(path[i - 1], path[i]);
      if (!made_.emplace(part.face, low, high).second) continue;  // border shared by two regions
      const Edge& edge = edges_.emplace_back(corners_[path[i - 1]], corners_[path[i]]);
      imprints_[part.face].push_back({{edge.from(), edge.to()}, border.condition});
    }
  }

  const Body& plain_;
  double tolerance_;  ///< [m]
  double merging_;
  std::size_t n_plain_ = 0;
  std::array<KnownValues, 3> known_;
  std::vector<Point> corners_;
  std::vector<Edge> edges_;
  std::deque<FacePart> frames_;  ///< whose addresses stay
  std::vector<Border> borders_;
  std::vector<std::tuple<std::size_t, const FacePart*, std::size_t>> isolated_;
  std::set<std::tuple<FaceId, std::size_t, std::size_t>> made_;
  Imprints imprints_;
};

}  // namespace

bool has_borders(const Body& plain, std::span<const ConditionRegion> regions) {
  return std::ranges::any_of(regions, [&](const ConditionRegion& region) {
    return std::ranges::any_of(region.parts, [&](const FacePart& part) {
      if (part.has_limits()) return true;
      const Patch& patch = plain.faces()[index(part.face)].patch;
      for (std::size_t k = 0; k < 2; ++k)
        if (part.lower[k] != patch.domain.lower[part.axis[k]] ||
            part.upper[k] != patch.domain.upper[part.axis[k]])
          return true;
      return false;
    });
  });
}

Complex imprint(const Body& plain, std::span<const ConditionRegion> regions) {
  return Imprinting(plain, regions).result();
}

}  // namespace crackle::geometry
