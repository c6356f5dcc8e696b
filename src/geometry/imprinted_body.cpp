// SPDX-License-Identifier: GPL-3.0-or-later
#include "imprinted_body.h"

#include "crackle/common/failure.h"
#include "crackle/common/index.h"
#include "crackle/geometry/mother_points.h"

#include "reflection.h"

#include <fmt/format.h>

#include <algorithm>
#include <bit>
#include <cmath>
#include <map>
#include <set>
#include <stdexcept>
#include <tuple>
#include <utility>

namespace crackle::geometry {

namespace {

/// Maximum number of pieces of a line for measuring its distance to others.
constexpr double most_pieces = 1000;

bool meet(const Box& a, const Box& b) {
  for (std::size_t i = 0; i < 3; ++i)
    if (a.lower[i] > b.upper[i] || b.lower[i] > a.upper[i]) return false;
  return true;
}

double distance_between(const std::array<plane::Point, 2>& a, const std::array<plane::Point, 2>& b) {
  return plane::distance(a[0], a[1], b[0], b[1]);
}

}  // namespace

/// Makes corners, edges and lines from the borders of regions.
class ImprintedBody::Imprinting {
public:
  Imprinting(ImprintedBody& body, std::span<const ConditionRegion> regions)
      : body_(body), plain_(*body.plain_), merging_(merging_share * std::ranges::max(plain_.size())) {
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

  void finish() {
    for (const Edge& edge : plain_.edges()) {
      const std::vector<std::size_t> path = corners_on(edge.from(), edge.to(), n_plain_);
      if (path.empty()) {
        edges_.push_back(edge);
        continue;
      }
      Point from = edge.from();
      for (const std::size_t i : path) {
        edges_.emplace_back(from, corners_[i]);
        from = corners_[i];
      }
      edges_.emplace_back(from, edge.to());
    }
    for (const Border& border : borders_) add_lines(border);
    for (const auto& [i, part, condition] : isolated_) add_isolated(i, *part, condition);
    body_.new_corners_.assign(corners_.begin() + static_cast<std::ptrdiff_t>(n_plain_), corners_.end());
    body_.shape_.corners = corners_;
    body_.shape_.edges = edges_;
  }

private:
  /// A border as requested by a region, before it is split by others: own coordinate `across` equals
  /// `position`.
  struct Border {
    const FacePart* part;
    std::size_t condition;
    std::size_t across;
    double position;
    double from, to;  ///< along the other own coordinate
  };

  static plane::Point place_on(const Border& border, double along) {
    return border.across == 0 ? plane::Point{border.position, along} : plane::Point{along, border.position};
  }

  /// The borders of a part that lie within its face, and the ends of those on its outline.
  static std::vector<Border> borders_of(const FacePart& part, std::size_t condition) {
    std::vector<Border> borders;
    for (std::size_t k = 0; k < 2; ++k) {
      const std::size_t axis = part.axis[k];
      std::set<double> positions{part.lower[k], part.upper[k]};
      positions.erase(part.patch.domain.lower[axis]);
      positions.erase(part.patch.domain.upper[axis]);
      for (const double position : positions)
        borders.push_back({&part, condition, k, position, part.lower[1 - k], part.upper[1 - k]});
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
    for (std::size_t i = 0; i < 3; ++i) {
      const auto near = known_[i].lower_bound(p[i] - body_.tolerance_);
      if (near != known_[i].end() && *near <= p[i] + body_.tolerance_)
        p[i] = *near;
      else
        known_[i].insert(p[i]);
    }
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
        if (other.part->face == part.face && other.across == border.across &&
            std::abs(other.position - border.position) <= merging_)
          border.position = other.position;
      add_clipped(border);
    }
    const bool has_ends = add_ends(part, condition);
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
    const FacePart& part = *border.part;
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

  void add_crossing(const Border& a, const Border& b) {
    if (a.part->face != b.part->face || a.across == b.across) return;
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

  Imprint& imprint_on(const FacePart& part) {
    const auto found = std::ranges::find(body_.imprints_, part.face, &Imprint::face);
    if (found != body_.imprints_.end()) return *found;
    body_.imprints_.push_back({part.face, part.axis, nowhere, {}});
    return body_.imprints_.back();
  }

  void add_lines(const Border& border) {
    const FacePart& part = *border.part;
    const std::size_t first = corner(place(part, place_on(border, border.from)));
    const std::size_t last = corner(place(part, place_on(border, border.to)));
    std::vector<std::size_t> path = corners_on(corners_[first], corners_[last], 0);
    path.insert(path.begin(), first);
    path.push_back(last);
    for (std::size_t i = 1; i < path.size(); ++i) {
      const auto [low, high] = std::minmax(path[i - 1], path[i]);
      if (!made_.emplace(part.face, low, high).second) continue;  // border shared by two regions
      const Edge& edge = edges_.emplace_back(corners_[path[i - 1]], corners_[path[i]]);
      add({{edge.from(), edge.to()},
           {own(part, edge.from()), own(part, edge.to())},
           border.across,
           freedom_along(edge),
           border.condition},
          part);
    }
  }

  /// The bit of the direction in which a point can move along an edge within a face.
  std::uint8_t freedom_along(const Edge& edge) const {
    const Point middle = edge.at(edge.length() / 2);
    const std::uint8_t movable = plain_.movable(middle);
    const Directions directions = plain_.directions(middle, movable);
    const Vector along = (edge.to() - edge.from()) / edge.length();
    int nearest = 0;
    for (int k = 1; k < directions.n; ++k)
      if (std::abs(dot(directions.vector[index(k)], along)) >
          std::abs(dot(directions.vector[index(nearest)], along)))
        nearest = k;
    std::uint8_t rest = movable;
    for (int k = 0; k < nearest; ++k) rest = static_cast<std::uint8_t>(rest & (rest - 1u));
    return static_cast<std::uint8_t>(rest & -rest);
  }

  void add_isolated(std::size_t number, const FacePart& part, std::size_t condition) {
    if (!made_.emplace(part.face, number, number).second) return;
    const Point& p = corners_[number];
    add({{p, p}, {own(part, p), own(part, p)}, 0, 0, condition}, part);
  }

  void add(Line line, const FacePart& part) {
    Imprint& imprint = imprint_on(part);
    for (Point end : line.end)
      for (const double shift : {-body_.tolerance_, body_.tolerance_})
        imprint.bounds.include(end + Point{shift, shift, shift});
    imprint.lines.push_back(std::move(line));
  }

  ImprintedBody& body_;
  const Body& plain_;
  double merging_;
  std::size_t n_plain_ = 0;
  std::array<std::set<double>, 3> known_;
  std::vector<Point> corners_;
  std::vector<Edge> edges_;
  std::vector<Border> borders_;
  std::vector<std::tuple<std::size_t, const FacePart*, std::size_t>> isolated_;
  std::set<std::tuple<FaceId, std::size_t, std::size_t>> made_;
};

bool ImprintedBody::is_needed(const Body& plain, std::span<const ConditionRegion> regions) {
  return std::ranges::any_of(regions, [&](const ConditionRegion& region) {
    return std::ranges::any_of(region.parts, [&](const FacePart& part) {
      const Patch& patch = plain.faces()[index(part.face)].patch;
      for (std::size_t k = 0; k < 2; ++k)
        if (part.lower[k] != patch.domain.lower[part.axis[k]] ||
            part.upper[k] != patch.domain.upper[part.axis[k]])
          return true;
      return false;
    });
  });
}

ImprintedBody::ImprintedBody(std::unique_ptr<const Body> plain, std::span<const ConditionRegion> regions)
    : plain_(std::move(plain)), tolerance_(wall_tolerance * std::ranges::max(plain_->size())) {
  shape_.bounds = plain_->bounds();
  shape_.volume = plain_->volume();
  shape_.faces = plain_->faces();
  shape_.inner_faces = plain_->inner_faces();
  shape_.material_volumes = plain_->material_volumes();
  shape_.interfaces = plain_->interfaces();
  shape_.crack_starts = plain_->crack_starts();
  shape_.outline = plain_->outline();
  Imprinting(*this, regions).finish();
}

plane::Point ImprintedBody::own(const Imprint& imprint, const Point& p) const {
  const Point full = patch(imprint).own(p);
  return {full[imprint.axis[0]], full[imprint.axis[1]]};
}

const ImprintedBody::Imprint* ImprintedBody::on(FaceId face) const {
  const auto found = std::ranges::find(imprints_, face, &Imprint::face);
  return found == imprints_.end() ? nullptr : &*found;
}

bool ImprintedBody::is_on(const Line& line, const Point& p) const {
  const Vector side = line.end[1] - line.end[0];
  const double squared = dot(side, side);
  const double share = squared > 0 ? std::clamp(dot(p - line.end[0], side) / squared, 0.0, 1.0) : 0;
  const Vector gap = p - (line.end[0] + share * side);
  return dot(gap, gap) <= tolerance_ * tolerance_;
}

std::uint8_t ImprintedBody::movable(const Point& p) const {
  std::uint8_t movable = plain_->movable(p);
  if (movable == 7 || movable == 0) return movable;
  for (const Imprint& imprint : imprints_) {
    if (!imprint.bounds.contains(p)) continue;
    for (const Line& line : imprint.lines)
      if (is_on(line, p)) movable &= line.movable;
  }
  const auto is_here = [&](const Point& corner) {
    const Vector gap = corner - p;
    return dot(gap, gap) <= tolerance_ * tolerance_;
  };
  return std::ranges::any_of(new_corners_, is_here) ? std::uint8_t{0} : movable;
}

double ImprintedBody::distance_to_outline(FaceId face, const Point& p) const {
  double nearest = plain_->distance_to_outline(face, p);
  if (const Imprint* imprint = on(face)) {
    const plane::Point place = own(*imprint, p);
    for (const Line& line : imprint->lines)
      nearest = std::min(nearest, plane::distance(place, line.own[0], line.own[1]));
  }
  return nearest;
}

std::optional<Point> ImprintedBody::passage(FaceId face, const Point& p, const Point& q,
                                            double margin) const {
  if (auto found = plain_->passage(face, p, q, margin)) return found;
  const Imprint* imprint = on(face);
  if (imprint == nullptr || !in_face(face, p) || !in_face(face, q)) return std::nullopt;
  const plane::Point a = own(*imprint, p);
  const plane::Point b = own(*imprint, q);
  for (const Line& line : imprint->lines) {
    const double before = a[line.across] - line.own[0][line.across];
    const double after = b[line.across] - line.own[0][line.across];
    if (!((before < -tolerance_ && after > tolerance_) || (before > tolerance_ && after < -tolerance_)))
      continue;
    const std::size_t along = 1 - line.across;
    const double meeting = a[along] + before / (before - after) * (b[along] - a[along]);
    const double length = line.own[1][along] - line.own[0][along];
    const double share = (meeting - line.own[0][along]) / length;
    if (!(share >= 0 && share <= 1)) continue;
    if (share * std::abs(length) < margin) return line.end[0];
    if ((1 - share) * std::abs(length) < margin) return line.end[1];
    return line.end[0] + share * (line.end[1] - line.end[0]);
  }
  return std::nullopt;
}

Point ImprintedBody::snapped(const Point& p, double tolerance) const {
  const Point q = plain_->snapped(p, tolerance);
  for (const Point& corner : new_corners_)
    if (norm(corner - q) <= tolerance) return corner;
  for (const Imprint& imprint : imprints_)
    for (const Line& line : imprint.lines) {
      const Vector side = line.end[1] - line.end[0];
      const double squared = dot(side, side);
      if (squared == 0) continue;
      const Point nearest = line.end[0] + std::clamp(dot(q - line.end[0], side) / squared, 0.0, 1.0) * side;
      if (norm(nearest - q) <= tolerance) return nearest;
    }
  return q;
}

/// True if a line of a face crosses the interior of a triangle in it.
bool ImprintedBody::crosses(const Imprint& imprint, const std::array<plane::Point, 3>& triangle) const {
  for (const Line& line : imprint.lines) {
    const std::size_t along = 1 - line.across;
    std::array<double, 3> height{};
    int n_below = 0;
    int n_above = 0;
    for (std::size_t i = 0; i < 3; ++i) {
      height[i] = triangle[i][line.across] - line.own[0][line.across];
      n_below += height[i] < -tolerance_;
      n_above += height[i] > tolerance_;
    }
    if (n_below == 0 || n_above == 0) continue;
    double from = infinity;
    double to = -infinity;
    const auto include = [&](double arc_length) {
      from = std::min(from, arc_length);
      to = std::max(to, arc_length);
    };
    for (std::size_t i = 0; i < 3; ++i) {
      const std::size_t j = (i + 1) % 3;
      if (std::abs(height[i]) <= tolerance_) include(triangle[i][along]);
      if ((height[i] > tolerance_ && height[j] < -tolerance_) ||
          (height[i] < -tolerance_ && height[j] > tolerance_))
        include(triangle[i][along] +
                height[i] / (height[i] - height[j]) * (triangle[j][along] - triangle[i][along]));
    }
    const auto [first, last] = std::minmax(line.own[0][along], line.own[1][along]);
    if (std::min(to, last) - std::max(from, first) > tolerance_) return true;
  }
  return false;
}

Containment ImprintedBody::classify(const std::array<Point, 4>& corners) const {
  const Containment plain = plain_->classify(corners);
  if (plain != Containment::inside) return plain;
  Box around = nowhere;
  for (const Point& p : corners) around.include(p);
  for (const Imprint& imprint : imprints_) {
    if (!meet(around, imprint.bounds)) continue;
    const Patch& face = patch(imprint);
    const Vector& normal = faces()[index(imprint.face)].outward;
    const double position = dot(normal, face.at(face.domain.lower));
    std::size_t n = 0;
    std::array<plane::Point, 3> triangle{};
    for (const Point& p : corners) {
      if (std::abs(dot(normal, p) - position) > tolerance_) continue;
      if (n == 3) return plain;  // flat on the face
      triangle[n++] = own(imprint, p);
    }
    if (n == 3 && crosses(imprint, triangle)) return Containment::straddling;
  }
  return plain;
}

std::vector<ImprintedBody::LineSource> ImprintedBody::line_sources(const input::Mesh& mesh) const {
  std::vector<LineSource> sources;
  const SpacingField without(*plain_, mesh);
  const double growth = shape_growth(mesh);
  for (const Imprint& imprint : imprints_) {
    std::vector<std::array<plane::Point, 2>> others;
    for (const Edge& edge : edges())
      if (in_face(imprint.face, edge.from()) && in_face(imprint.face, edge.to()))
        others.push_back({own(imprint, edge.from()), own(imprint, edge.to())});
    for (const Line& line : imprint.lines) {
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
        const std::array<plane::Point, 2> own{at(first, line.own), at(last, line.own)};
        double gap = length > 0 ? length : mesh.spacing;
        for (const auto& other : others) {
          const bool touches = std::ranges::any_of(other, [&](const plane::Point& p) {
            return plane::distance(p, line.own[0], line.own[1]) <= tolerance_;
          });
          if (!touches) gap = std::min(gap, distance_between(own, other));
        }
        if (!(gap * fine_enough < without(at((first + last) / 2, line.end)))) continue;
        Box region{at(first, line.end), at(first, line.end)};
        region.include(at(last, line.end));
        sources.push_back({line.condition,
                           {region, gap, growth, fmt::format("the region of boundary[{}]", line.condition)}});
      }
    }
  }
  return sources;
}

std::vector<SpacingSource> ImprintedBody::spacing_sources(const input::Mesh& mesh) const {
  std::vector<SpacingSource> sources = plain_->spacing_sources(mesh);
  for (LineSource& one : line_sources(mesh)) sources.push_back(std::move(one.source));
  return sources;
}

std::vector<RegionRefinement> ImprintedBody::refinements(const input::Mesh& mesh) const {
  std::map<std::size_t, double> finest;
  for (const LineSource& one : line_sources(mesh)) {
    const auto [entry, is_new] = finest.emplace(one.condition, one.source.spacing);
    entry->second = std::min(entry->second, one.source.spacing);
  }
  std::vector<RegionRefinement> result;
  for (const auto& [condition, spacing] : finest) result.push_back({condition, spacing});
  return result;
}

/// Keeps those symmetries of the body that map borders onto borders.
std::vector<Symmetry> ImprintedBody::symmetries() const {
  std::vector<Symmetry> all = plain_->symmetries();
  const double near = 4 * tolerance_;
  const auto are_near = [&](const Point& a, const Point& b) { return norm(a - b) <= near; };
  const auto is_line = [&](const Point& from, const Point& to) {
    return std::ranges::any_of(imprints_, [&](const Imprint& imprint) {
      return std::ranges::any_of(imprint.lines, [&](const Line& line) {
        return (are_near(from, line.end[0]) && are_near(to, line.end[1])) ||
               (are_near(from, line.end[1]) && are_near(to, line.end[0]));
      });
    });
  };
  std::erase_if(all, [&](const Symmetry& symmetry) {
    const bool maps_corners = std::ranges::all_of(new_corners_, [&](const Point& corner) {
      const Point image = symmetry.image(corner);
      return std::ranges::any_of(new_corners_, [&](const Point& other) { return are_near(image, other); });
    });
    return !maps_corners || !std::ranges::all_of(imprints_, [&](const Imprint& imprint) {
      return std::ranges::all_of(imprint.lines, [&](const Line& line) {
        return is_line(symmetry.image(line.end[0]), symmetry.image(line.end[1]));
      });
    });
  });
  return all;
}

}  // namespace crackle::geometry
