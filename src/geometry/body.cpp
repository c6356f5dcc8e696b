// SPDX-License-Identifier: GPL-3.0-or-later
// Location of points and tetrahedra in a body.
#include "geometry/body.h"

#include "tolerances.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <map>
#include <numeric>
#include <stdexcept>
#include <utility>

namespace crackle::geometry {

namespace {

constexpr double cells_per_facet = 16;
constexpr double fewest_cells = 4096;
constexpr double most_cells = 1 << 18;
constexpr std::size_t few_facets = 32;  ///< among which a search takes no longer than in the grid

/// Place of a cell's reference point in the cell: on no plane of a regular arrangement.
constexpr Vector reference_share{0.414213562373095, 0.732050807568877, 0.236067977499790};

/// Directions that differ by less than this angle are one [rad].
constexpr double one_direction = 1e-9;

/// The axis along which a unit vector points, exactly and in either direction, or -1.
int axis_of(const Vector& unit) {
  for (int i = 0; i < 3; ++i)
    if (unit[index((i + 1) % 3)] == 0 && unit[index((i + 2) % 3)] == 0) return i;
  return -1;
}

Directions sorted(std::span<const Vector> vectors) {
  Directions result;
  const auto add = [&](const Vector& vector) { result.vector[index(result.n++)] = vector; };
  for (int i = 0; i < 3; ++i)
    if (std::ranges::find(vectors, i, axis_of) != vectors.end()) {
      Vector unit{};
      unit[index(i)] = 1;
      add(unit);
    }
  for (const Vector& vector : vectors)
    if (axis_of(vector) < 0) add(vector);
  return result;
}

double distance_squared(const Point& a, const Point& b) {
  const Vector gap = a - b;
  return dot(gap, gap);
}

}  // namespace

std::uint8_t Directions::mask() const {
  unsigned mask = 0;
  unsigned other = 8;
  for (int k = 0; k < n; ++k) {
    const int axis = axis_of(vector[index(k)]);
    mask |= axis >= 0 ? 1u << axis : other;
    if (axis < 0) other *= 2;
  }
  return static_cast<std::uint8_t>(mask);
}

Body::Body(Complex complex)
    : complex_(std::move(complex)), tolerance_(wall_tolerance * std::ranges::max(size())) {
  add_facets();
  make_grid();
  join_edges();
  join_corners();
}

void Body::add_facets() {
  for (std::size_t id = 0; id < n_meshed_faces(); ++id) {
    const Face& face = meshed_face(static_cast<FaceId>(id));
    const auto axes = face.spanning_axes();
    const std::size_t normal = 3 - axes[0] - axes[1];
    Facet& facet = facets_.emplace_back();
    facet.normal = face.patch.axes[normal];
    facet.own_origin = face.patch.origin;
    facet.along = {face.patch.axes[axes[0]], face.patch.axes[axes[1]]};
    Point flat{};
    flat[normal] = face.patch.domain.lower[normal];
    facet.origin = face.patch.at(flat);
    facet.axis = axis_of(facet.normal);
    facet.first = static_cast<FaceId>(id);
    for (std::size_t k = 0; k < 2; ++k) {
      facet.bounds.lower[k] = face.patch.domain.lower[axes[k]];
      facet.bounds.upper[k] = face.patch.domain.upper[axes[k]];
    }
    if (face.rim.empty()) continue;
    std::vector<plane::Side> sides;
    for (const auto& [from, to] : face.rim) sides.push_back(plane::side_between(from, to, -1));
    facet.rim.emplace(std::move(sides), facet.bounds, tolerance_);
  }
}

Point Body::reference_of(const CellIndex& cell) const {
  Point p = bounds().lower;
  for (std::size_t i = 0; i < 3; ++i)
    p[i] += (static_cast<double>(cell[i]) + reference_share[i]) * cell_size_[i];
  return p;
}

/// True if the plane of a facet and its rectangle meet a cell.
bool Body::meets(const Facet& facet, const CellIndex& cell) const {
  Point centre = bounds().lower;
  Vector half{};
  for (std::size_t i = 0; i < 3; ++i) {
    centre[i] += (static_cast<double>(cell[i]) + 0.5) * cell_size_[i];
    half[i] = cell_size_[i] / 2 * (1 + 1e-9) + 2 * tolerance_;
  }
  const auto reach = [&](const Vector& direction) {
    return std::abs(direction[0]) * half[0] + std::abs(direction[1]) * half[1] +
           std::abs(direction[2]) * half[2];
  };
  if (std::abs(facet.height(centre)) > reach(facet.normal)) return false;
  const plane::Point own = facet.own(centre);
  for (std::size_t k = 0; k < 2; ++k)
    if (own[k] < facet.bounds.lower[k] - reach(facet.along[k]) ||
        own[k] > facet.bounds.upper[k] + reach(facet.along[k]))
      return false;
  return true;
}

Body::CellIndex Body::cell_of(const Point& p) const {
  CellIndex cell{};
  for (std::size_t i = 0; i < 3; ++i)
    cell[i] = static_cast<std::size_t>(
        std::clamp((p[i] - bounds().lower[i]) / cell_size_[i], 0.0, static_cast<double>(n_[i] - 1)));
  return cell;
}

/// Divides the bounding box into cells, and finds for each what meets it and whether its reference point is
/// inside: from cell to cell, by the facets between the reference points.
void Body::make_grid() {
  const double wanted =
      std::clamp(cells_per_facet * static_cast<double>(facets_.size()), fewest_cells, most_cells);
  const double volume = size()[0] * size()[1] * size()[2];
  for (std::size_t i = 0; i < 3; ++i) {
    n_[i] = volume > 0 ? static_cast<std::size_t>(
                             std::clamp(std::ceil(size()[i] / std::cbrt(volume / wanted)), 1.0, wanted))
                       : 1;
    cell_size_[i] = volume > 0 ? size()[i] / static_cast<double>(n_[i]) : 1;
  }
  std::vector<std::pair<std::size_t, std::int32_t>> found;
  for (std::size_t f = 0; f < facets_.size(); ++f) {
    if (!facets_[f].rim) continue;
    Box box = meshed_face(static_cast<FaceId>(f)).patch.bounds();
    for (std::size_t i = 0; i < 3; ++i) {
      box.lower[i] -= 2 * tolerance_;
      box.upper[i] += 2 * tolerance_;
    }
    const CellIndex low = cell_of(box.lower), high = cell_of(box.upper);
    for (std::size_t z = low[2]; z <= high[2]; ++z)
      for (std::size_t y = low[1]; y <= high[1]; ++y)
        for (std::size_t x = low[0]; x <= high[0]; ++x)
          if (meets(facets_[f], {x, y, z})) found.emplace_back(number_of({x, y, z}), static_cast<int>(f));
  }
  std::ranges::sort(found);
  const std::size_t n_cells = n_[0] * n_[1] * n_[2];
  first_.assign(n_cells + 1, 0);
  for (const auto& [cell, facet] : found) {
    ++first_[cell + 1];
    of_cell_.push_back(facet);
  }
  for (std::size_t i = 0; i < n_cells; ++i) first_[i + 1] += first_[i];

  is_inside_.assign(n_cells, 0);
  std::vector<std::int32_t> between;
  for (std::size_t z = 0; z < n_[2]; ++z)
    for (std::size_t y = 0; y < n_[1]; ++y)
      for (std::size_t x = 0; x < n_[0]; ++x) {
        const CellIndex cell{x, y, z};
        const std::size_t axis = x > 0 ? 0 : y > 0 ? 1 : 2;
        const Point here = reference_of(cell);
        const auto own = facets_in(number_of(cell));
        between.assign(own.begin(), own.end());
        Point before = here;
        bool was_inside = false;
        if (cell[axis] > 0) {
          CellIndex previous = cell;
          --previous[axis];
          before = reference_of(previous);
          was_inside = is_inside_[number_of(previous)] != 0;
          const auto others = facets_in(number_of(previous));
          between.clear();
          std::ranges::set_union(own, others, std::back_inserter(between));
        } else {
          before[2] = bounds().lower[2] - cell_size_[2];
        }
        is_inside_[number_of(cell)] = was_inside != (n_between(between, before, here) % 2 == 1);
      }
}

/// The number of facets of the surface that part two points.
std::size_t Body::n_between(std::span<const std::int32_t> facets, const Point& p, const Point& q) const {
  std::size_t n = 0;
  for (const std::int32_t f : facets) {
    if (index(f) >= faces().size()) continue;
    const Facet& facet = facets_[index(f)];
    const double before = facet.height(p);
    const double after = facet.height(q);
    if ((before > 0) != (after > 0) && facet.holds(facet.own(p + before / (before - after) * (q - p)))) ++n;
  }
  return n;
}

bool Body::is_inside(const Point& p) const {
  const CellIndex cell = cell_of(p);
  const std::size_t number = number_of(cell);
  const bool is_reference_inside = is_inside_[number] != 0;
  const auto near = facets_in(number);
  if (near.empty()) return is_reference_inside;
  return is_reference_inside != (n_between(near, p, reference_of(cell)) % 2 == 1);
}

/// Finds the faces of each edge, and divides their borders at its ends.
void Body::join_edges() {
  std::vector<std::vector<plane::Side>> rims(facets_.size()), lines(facets_.size());
  for (std::size_t e = 0; e < edges().size(); ++e) {
    const Edge& edge = edges()[e];
    Junction& junction = at_edge_.emplace_back();
    const Point middle = edge.at(edge.length() / 2);
    for (const std::int32_t f : facets_in(number_of(cell_of(middle)))) {
      const Facet& facet = facets_[index(f)];
      const auto is_near = [&](const Point& p) { return std::abs(facet.height(p)) <= tolerance_; };
      const plane::Point own = facet.own(middle);
      if (!is_near(edge.from()) || !is_near(edge.to()) || !facet.holds(own)) continue;
      junction.faces.push_back(f);
      if (facet.axis >= 0) junction.exact_axes |= 1u << facet.axis;
      bool is_rim = false;
      facet.rim->for_sides_at(own, [&](std::size_t) { is_rim = true; });
      (is_rim ? rims : lines)[index(f)].push_back(
          plane::side_between(facet.own(edge.from()), facet.own(edge.to()), static_cast<int>(e)));
    }
    if (junction.faces.size() != 2 || index(junction.faces[0]) < faces().size()) continue;
    Facet& a = facets_[index(junction.faces[0])];
    Facet& b = facets_[index(junction.faces[1])];
    if (norm(cross(a.normal, b.normal)) > one_direction) continue;
    junction.is_crease = false;
    const FaceId kept = std::min(a.first, b.first), replaced = std::max(a.first, b.first);
    for (Facet& facet : facets_)
      if (facet.first == replaced) facet.first = kept;
  }
  for (std::size_t f = 0; f < facets_.size(); ++f) {
    Facet& facet = facets_[f];
    const auto length_of = [](const std::vector<plane::Side>& sides) {
      return std::accumulate(sides.begin(), sides.end(), 0.0,
                             [](double sum, const plane::Side& side) { return sum + side.length; });
    };
    // An edge may leave the border where corners very close to it have been merged.
    if (facet.rim && std::abs(length_of(rims[f]) - length_of(facet.rim->sides())) <= tolerance_ * 1e3)
      facet.rim.emplace(std::move(rims[f]), facet.bounds, tolerance_);
    if (!lines[f].empty()) facet.lines.emplace(std::move(lines[f]), facet.bounds, tolerance_);
    facets_[index(facet.first)].joined.push_back(static_cast<FaceId>(f));
  }
}

/// Finds the corners at the ends of edges, and those within faces.
void Body::join_corners() {
  std::map<Point, std::int32_t> numbers;
  for (std::size_t c = 0; c < corners().size(); ++c)
    numbers.emplace(corners()[c], static_cast<std::int32_t>(c));
  at_corner_.resize(corners().size());
  const auto number_at = [&](const Point& p) {
    const auto found = numbers.find(p);
    return found == numbers.end() ? -1 : found->second;
  };
  for (std::size_t e = 0; e < edges().size(); ++e) {
    ends_.push_back({number_at(edges()[e].from()), number_at(edges()[e].to())});
    for (const std::int32_t corner : {ends_[e].from, ends_[e].to}) {
      if (corner < 0) continue;
      Junction& junction = at_corner_[index(corner)];
      junction.exact_axes |= at_edge_[e].exact_axes;
      for (const FaceId face : at_edge_[e].faces)
        if (std::ranges::find(junction.faces, face) == junction.faces.end()) junction.faces.push_back(face);
    }
  }
  for (std::size_t c = 0; c < corners().size(); ++c) {
    Junction& junction = at_corner_[c];
    if (!junction.faces.empty()) continue;
    for (const std::int32_t f : facets_in(number_of(cell_of(corners()[c])))) {
      Facet& facet = facets_[index(f)];
      if (!is_in_plane(facet, corners()[c]) || !facet.holds(facet.own(corners()[c]))) continue;
      junction.faces.push_back(f);
      facet.points.push_back(static_cast<std::int32_t>(c));
    }
  }
}

std::vector<FaceId> Body::faces_named(const std::string& name) const {
  std::vector<FaceId> ids;
  for (std::size_t id = 0; id < faces().size(); ++id)
    if (std::ranges::find(faces()[id].names, name) != faces()[id].names.end())
      ids.push_back(static_cast<FaceId>(id));
  return ids;
}

FaceId Body::face_of(const std::array<Point, 3>& corners) const {
  const Point middle = (corners[0] + corners[1] + corners[2]) / 3;
  for (const FaceId id : facets_in(number_of(cell_of(middle))))
    if (index(id) < faces().size() &&
        std::ranges::all_of(corners, [&](const Point& p) { return in_face(id, p); }))
      return id;
  throw std::runtime_error("realization: a boundary triangle lies in no face of the body");
}

bool Body::in_face(FaceId face, const Point& p) const {
  const Facet& facet = facets_[index(face)];
  return is_in_plane(facet, p) && facet.holds(facet.own(p));
}

bool Body::is_at(const Junction& junction, const Point& there, const Point& p) const {
  for (std::size_t i = 0; i < 3; ++i)
    if (((junction.exact_axes >> i) & 1u) && p[i] != there[i]) return false;
  return distance_squared(p, there) <= tolerance_ * tolerance_;
}

PlaceId Body::place_of(const Point& p) const {
  for (std::size_t i = 0; i < 3; ++i)
    if (p[i] < bounds().lower[i] - tolerance_ || p[i] > bounds().upper[i] + tolerance_) return out_of_body;
  PlaceId place = in_interior;
  for (const std::int32_t f : facets_in(number_of(cell_of(p)))) {
    const Facet& facet = facets_[index(f)];
    if (!is_in_plane(facet, p)) continue;
    const plane::Point own = facet.own(p);
    if (!facet.holds(own)) continue;
    if (place == in_interior) place = facet.first;
    PlaceId corner = in_interior;
    const auto at_corner = [&](std::int32_t number) {
      if (number >= 0 && is_at(at_corner_[index(number)], corners()[index(number)], p))
        corner = place_of_corner(index(number));
    };
    const auto visit = [&](const plane::SideIndex& sides) {
      sides.for_sides_at(own, [&](std::size_t side) {
        const int e = sides.sides()[side].part;
        if (e < 0) return;
        at_corner(ends_[index(e)].from);
        at_corner(ends_[index(e)].to);
        const Junction& junction = at_edge_[index(e)];
        if (junction.is_crease && is_at(junction, edges()[index(e)].nearest(p), p))
          place = place_of_edge(index(e));
      });
    };
    visit(*facet.rim);
    if (facet.lines) visit(*facet.lines);
    for (const std::int32_t number : facet.points) at_corner(number);
    if (corner >= 0) return corner;
    if (index(place) >= n_meshed_faces()) return place;
  }
  if (place == in_interior && !is_inside(p)) return out_of_body;
  return place;
}

std::vector<PlaceId> Body::places_of(std::span<const Point> points) const {
  std::vector<PlaceId> places;
  places.reserve(points.size());
  for (const Point& p : points) places.push_back(place_of(p));
  return places;
}

std::span<const FaceId> Body::faces_at(PlaceId place) const {
  if (place < 0) return {};
  std::size_t number = index(place);
  if (number < n_meshed_faces()) return facets_[number].joined;
  number -= n_meshed_faces();
  return number < edges().size() ? at_edge_[number].faces : at_corner_[number - edges().size()].faces;
}

Directions Body::directions(PlaceId place) const {
  if (place < 0) return sorted(std::array<Vector, 3>{{{1, 0, 0}, {0, 1, 0}, {0, 0, 1}}});
  const std::size_t number = index(place);
  if (number < n_meshed_faces()) return sorted(facets_[number].along);
  if (number >= n_meshed_faces() + edges().size()) return {};
  const std::size_t e = number - n_meshed_faces();
  Vector along = edges()[e].direction();
  // That of a face, so that equal directions have equal bits.
  for (const FaceId face : at_edge_[e].faces)
    for (const Vector& axis : facets_[index(face)].along)
      if (norm(cross(axis, edges()[e].direction())) <= one_direction) along = axis;
  return sorted({&along, 1});
}

double Body::Facet::distance_to_border(const plane::Point& own) const {
  return std::min(rim->distance(own), lines ? lines->distance(own) : infinity);
}

double Body::distance_to_outline(FaceId face, const Point& p) const {
  const Facet& facet = facets_[index(face)];
  const plane::Point own = facet.own(p);
  if (!facet.holds(own)) return 0;
  double nearest = facet.distance_to_border(own);
  for (const std::int32_t number : facet.points)
    nearest = std::min(nearest, plane::distance(own, facet.own(corners()[index(number)]),
                                                facet.own(corners()[index(number)])));
  return nearest;
}

/// @param limit larger distances are not exact: the result is then some value not below it
double Body::distance(const Facet& facet, const Point& p, double limit) const {
  const double height = std::abs(facet.height(p));
  if (height >= limit) return height;
  const plane::Point own = facet.own(p);
  return facet.holds(own) ? height : std::hypot(height, facet.rim->distance(own, limit));
}

double Body::distance_to_surface(const Point& p) const {
  return contains(p) ? distance_to_faces(p, infinity, {}) : 0;
}

double Body::distance_to_faces(const Point& p, double limit,
                               const std::function<bool(FaceId)>& counts) const {
  double nearest = limit;
  const auto look_at = [&](std::size_t f) {
    if (!counts || counts(static_cast<FaceId>(f)))
      nearest = std::min(nearest, distance(facets_[f], p, nearest));
  };
  if (facets_.size() <= few_facets) {
    for (std::size_t f = 0; f < facets_.size(); ++f) look_at(f);
    return nearest;
  }
  const CellIndex cell = cell_of(p);
  const double step = std::ranges::min(cell_size_);
  // The distance of a layer of cells along an axis.
  const auto gap = [&](std::size_t i, std::size_t at) {
    const double lower = bounds().lower[i] + static_cast<double>(at) * cell_size_[i];
    return std::max({0.0, lower - p[i], p[i] - lower - cell_size_[i]});
  };
  // The facet's nearest place is in one of its cells, none of which is farther away.
  const auto is_near = [&](double square) {
    return square <= (nearest + 4 * tolerance_) * (nearest + 4 * tolerance_);
  };
  const auto search = [&](const CellIndex& other) {
    for (const std::int32_t f : facets_in(number_of(other))) look_at(index(f));
  };
  // Search shells of cells until those farther out cannot be closer.
  const std::size_t most = std::ranges::max(n_);
  for (std::size_t shell = 0; shell <= most; ++shell) {
    if (shell > 0 && nearest <= (static_cast<double>(shell) - 1) * step) break;
    CellIndex low{}, high{};
    for (std::size_t i = 0; i < 3; ++i) {
      low[i] = cell[i] >= shell ? cell[i] - shell : 0;
      high[i] = std::min(cell[i] + shell, n_[i] - 1);
    }
    const auto is_end = [&](std::size_t i, std::size_t at) {
      return at + shell == cell[i] || at == cell[i] + shell;
    };
    for (std::size_t z = low[2]; z <= high[2]; ++z)
      for (std::size_t y = low[1]; y <= high[1]; ++y) {
        const double gap_z = gap(2, z), gap_y = gap(1, y), of_row = gap_z * gap_z + gap_y * gap_y;
        if (!is_near(of_row)) continue;
        const auto visit = [&](std::size_t x) {
          const double gap_x = gap(0, x);
          if (is_near(of_row + gap_x * gap_x)) search({x, y, z});
        };
        if (is_end(2, z) || is_end(1, y)) {
          for (std::size_t x = low[0]; x <= high[0]; ++x) visit(x);
        } else {
          if (cell[0] >= shell) visit(cell[0] - shell);
          if (cell[0] + shell < n_[0]) visit(cell[0] + shell);
        }
      }
  }
  return nearest;
}

std::vector<FaceId> Body::faces_near(const Box& box) const {
  std::vector<FaceId> near;
  const CellIndex low = cell_of(box.lower), high = cell_of(box.upper);
  for (std::size_t z = low[2]; z <= high[2]; ++z)
    for (std::size_t y = low[1]; y <= high[1]; ++y)
      for (std::size_t x = low[0]; x <= high[0]; ++x) {
        const auto here = facets_in(number_of({x, y, z}));
        near.insert(near.end(), here.begin(), here.end());
      }
  std::ranges::sort(near);
  near.erase(std::unique(near.begin(), near.end()), near.end());
  return near;
}

std::optional<Point> Body::passage(FaceId face, const Point& p, const Point& q, double margin) const {
  const Facet& facet = facets_[index(face)];
  const auto parts = [near = tolerance_](double before, double after) {
    return (before < -near && after > near) || (before > near && after < -near);
  };
  const double before = facet.height(p);
  const double after = facet.height(q);
  if (parts(before, after)) {
    const Point meeting = p + before / (before - after) * (q - p);
    const plane::Point own = facet.own(meeting);
    if (!facet.holds(own)) return {};
    const Edge* nearest = nullptr;
    for (const auto* sides : {&facet.rim, &facet.lines})
      if (*sides && (*sides)->distance(own) < margin)
        for (const plane::Side& side : (*sides)->sides())
          if (side.part >= 0 && (nearest == nullptr ||
                                 edges()[index(side.part)].distance(meeting) < nearest->distance(meeting)))
            nearest = &edges()[index(side.part)];
    if (nearest != nullptr) return nearest->nearest(meeting);
    const Face& own_face = meshed_face(face);
    const auto axes = own_face.spanning_axes();
    Point full = own_face.patch.domain.lower;
    for (std::size_t k = 0; k < 2; ++k) full[axes[k]] = own[k];
    return own_face.patch.at(full);
  }
  if (!facet.lines || !in_face(face, p) || !in_face(face, q)) return {};
  const plane::Point a = facet.own(p);
  const plane::Point b = facet.own(q);
  for (const plane::Side& side : facet.lines->sides()) {
    const double left = side.height(a);
    const double right = side.height(b);
    if (!parts(left, right)) continue;
    const double arc_length = side.arc_length(plane::between(a, b, left / (left - right)));
    if (!(arc_length >= 0 && arc_length <= side.length)) continue;
    const Edge& edge = edges()[index(side.part)];
    if (arc_length < margin) return edge.from();
    if (side.length - arc_length < margin) return edge.to();
    return edge.at(arc_length);
  }
  return {};
}

Point Body::snapped(const Point& p, double tolerance) const {
  const auto nearest_corner = std::ranges::min_element(
      corners(), {}, [&](const Point& corner) { return distance_squared(corner, p); });
  if (nearest_corner != corners().end() && norm(*nearest_corner - p) <= tolerance) return *nearest_corner;
  const auto nearest_edge =
      std::ranges::min_element(edges(), {}, [&](const Edge& edge) { return edge.distance(p); });
  if (nearest_edge != edges().end() && nearest_edge->distance(p) <= tolerance)
    return nearest_edge->nearest(p);
  for (const Facet& facet : facets_) {
    if (!facet.rim || !(distance(facet, p, infinity) <= tolerance)) continue;
    Point result = p - facet.height(p) * facet.normal;
    if (facet.axis >= 0) result[index(facet.axis)] = facet.origin[index(facet.axis)];
    return result;
  }
  return p;
}

/// True if the section of a tetrahedron with the plane of a facet overlaps the facet.
bool Body::crosses(const Facet& facet, const std::array<Point, 4>& corners,
                   const std::array<double, 4>& height) const {
  std::array<plane::Point, 6> section;
  std::size_t n = 0;
  plane::Bounds bounds{{infinity, infinity}, {-infinity, -infinity}};
  const auto add = [&](const plane::Point& own) {
    section[n++] = own;
    for (std::size_t k = 0; k < 2; ++k) {
      bounds.lower[k] = std::min(bounds.lower[k], own[k]);
      bounds.upper[k] = std::max(bounds.upper[k], own[k]);
    }
  };
  std::array<plane::Point, 4> own;
  for (std::size_t i = 0; i < 4; ++i) own[i] = facet.own(corners[i]);
  for (std::size_t i = 0; i < 4; ++i) {
    if (std::abs(height[i]) <= tolerance_) add(own[i]);
    for (std::size_t j = 0; j < i; ++j)
      if ((height[i] > tolerance_ && height[j] < -tolerance_) ||
          (height[j] > tolerance_ && height[i] < -tolerance_))
        add(plane::between(own[i], own[j], height[i] / (height[i] - height[j])));
  }
  for (std::size_t k = 0; k < 2; ++k)
    if (bounds.upper[k] <= facet.bounds.lower[k] + tolerance_ ||
        bounds.lower[k] >= facet.bounds.upper[k] - tolerance_)
      return false;
  return facet.rim->cover(std::span<const plane::Point>(section.data(), n)) != plane::Cover::outside;
}

Containment Body::classify(const std::array<Point, 4>& corners) const {
  Box around{corners[0], corners[0]};
  Point centre{};
  for (const Point& p : corners) {
    around.include(p);
    centre = centre + p / 4;
  }
  const CellIndex low = cell_of(around.lower), high = cell_of(around.upper);
  bool is_flat = false;
  // Facets with lines that have three corners of the tetrahedron.
  std::array<std::pair<const Facet*, unsigned>, 4> lined;
  std::size_t n_lined = 0;
  for (std::size_t z = low[2]; z <= high[2]; ++z)
    for (std::size_t y = low[1]; y <= high[1]; ++y)
      for (std::size_t x = low[0]; x <= high[0]; ++x)
        for (const std::int32_t f : facets_in(number_of({x, y, z}))) {
          const Facet& facet = facets_[index(f)];
          std::array<double, 4> height;
          unsigned above = 0, below = 0;
          for (unsigned i = 0; i < 4; ++i) {
            height[i] = facet.height(corners[i]);
            above |= (height[i] > tolerance_ ? 1u : 0u) << i;
            below |= (height[i] < -tolerance_ ? 1u : 0u) << i;
          }
          if (above != 0 && below != 0) {
            if (crosses(facet, corners, height)) return Containment::straddling;
            continue;
          }
          is_flat = is_flat || ((above | below) == 0 && index(f) < faces().size());
          if (!facet.lines || std::popcount(above | below) != 1) continue;
          const auto end = lined.begin() + static_cast<std::ptrdiff_t>(n_lined);
          const std::pair entry{&facet, above | below};
          if (n_lined < lined.size() && std::find(lined.begin(), end, entry) == end) lined[n_lined++] = entry;
        }
  if (is_flat || !is_inside(centre)) return Containment::outside;
  for (std::size_t k = 0; k < n_lined; ++k) {
    const auto& [facet, opposite] = lined[k];
    std::array<plane::Point, 3> triangle;
    for (std::size_t i = 0, n = 0; i < 4; ++i)
      if (((opposite >> i) & 1u) == 0) triangle[n++] = facet->own(corners[i]);
    if (facet->lines->cover(std::span<const plane::Point>(triangle)) == plane::Cover::crossing)
      return Containment::straddling;
  }
  return Containment::inside;
}

std::vector<SpacingSource> Body::spacing_sources(const input::Mesh& mesh) const {
  std::vector<SpacingSource> sources;
  for (const SpacingRule& rule : complex_.spacing_rules) rule(*this, mesh, sources);
  return sources;
}

}  // namespace crackle::geometry
