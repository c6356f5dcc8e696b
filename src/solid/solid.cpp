// SPDX-License-Identifier: GPL-3.0-or-later
#include "solid/solid.h"

#include "common/checksum.h"
#include "common/failure.h"
#include "common/index.h"
#include "common/real.h"

#include "surface.h"

#include <fmt/format.h>
#include <Eigen/Dense>

#include <algorithm>
#include <cmath>
#include <map>
#include <numbers>
#include <numeric>
#include <set>
#include <utility>

namespace crackle::solid {

namespace {

/// Points this close to a plane or a line are on it, relative to the body's size: less than geometry::Body's
/// tolerance.
constexpr double flatness = 2.5e-13;
/// Edges and facets are higher than this share of the body's size.
constexpr double least_share = 1e-6;
/// Points this close to the plane of a face are meant to be on it, relative to the largest coordinate.
constexpr double precision = 1e-6;
/// Least cosine of the angle between facets in one plane.
constexpr double same_side = 0.99;
/// Faces that meet at less lie on each other [rad].
constexpr double least_angle = 1e-6;
/// Facets that meet at less than this angle belong to one face [rad].
constexpr double smooth_angle = 20 * std::numbers::pi / 180;

constexpr std::array<std::array<const char*, 2>, 3> end_names{
    {{"x-min", "x-max"}, {"y-min", "y-max"}, {"z-min", "z-max"}}};

/// Merges points with equal coordinates, and leaves out points of no polygon.
void merge_points(Facets& facets) {
  std::map<Vector, std::size_t> numbers;
  std::vector<Vector> points;
  for (Polygon& polygon : facets.polygons)
    for (std::size_t& corner : polygon) {
      const Vector& p = facets.points[corner];
      const auto [entry, is_new] = numbers.emplace(p, points.size());
      if (is_new) points.push_back(p);
      corner = entry->second;
    }
  facets.points = std::move(points);
}

void check_facets(const Facets& facets, const std::string& unit) {
  if (facets.polygons.empty()) fail("has no facets");
  for (const Polygon& polygon : facets.polygons) {
    if (polygon.size() < 3) fail("has a facet with {} corners", polygon.size());
    for (const std::size_t corner : polygon) {
      if (corner >= facets.points.size())
        fail("has a facet with corner {}, but only {} points", corner, facets.points.size());
      for (const double coordinate : facets.points[corner])
        if (!(std::abs(coordinate) < 1e12))
          fail("has a point at {}", show_place(facets.points[corner], unit));
    }
  }
}

void check_corners(const Facets& facets, const std::string& unit) {
  for (Polygon corners : facets.polygons) {
    std::ranges::sort(corners);
    const auto twice = std::ranges::adjacent_find(corners);
    if (twice != corners.end())
      fail("has a facet with the corner {} twice; remove it", show_place(facets.points[*twice], unit));
  }
}

/// Divides the facets into faces.
class FaceMaker {
public:
  FaceMaker(Surface surface, std::vector<std::string> groups, double metres, std::string unit)
      : group_(std::move(surface.group)),
        groups_(std::move(groups)),
        metres_(metres),
        unit_(std::move(unit)) {
    solid_.points = std::move(surface.points);
    solid_.facets = std::move(surface.facets);
    for (Vector& p : solid_.points) p = metres * p;
  }

  Solid make() {
    find_bounds();
    measure();
    find_neighbours();
    flatten();
    grow_faces();
    add_edges();
    add_names();
    return std::move(solid_);
  }

private:
  const Vector& point(int number) const { return solid_.points[index(number)]; }
  std::string show(const Vector& p) const { return show_place(p / metres_, unit_); }

  void find_bounds() {
    Vector lower = solid_.points.front(), upper = lower;
    for (const Vector& p : solid_.points)
      for (std::size_t i = 0; i < 3; ++i) {
        lower[i] = std::min(lower[i], p[i]);
        upper[i] = std::max(upper[i], p[i]);
      }
    for (std::size_t i = 0; i < 3; ++i) {
      solid_.bounds[i] = {lower[i], upper[i]};
      size_ = std::max(size_, upper[i] - lower[i]);
      reach_ = std::max({reach_, std::abs(lower[i]), std::abs(upper[i])});
    }
    middle_ = (lower + upper) / 2;
    for (std::size_t i = 0; i < 3; ++i) align(i);
  }

  void measure() {
    area_.clear();
    normal_.clear();
    solid_.volume = 0;
    for (const auto& [a, b, c] : solid_.facets) {
      const Vector twice = cross(point(b) - point(a), point(c) - point(a));
      area_.push_back(norm(twice) / 2);
      normal_.push_back(twice / norm(twice));
      solid_.volume += dot(point(a) - middle_, twice) / 6;
      const double longest =
          std::max({norm(point(b) - point(a)), norm(point(c) - point(b)), norm(point(a) - point(c))});
      if (!(norm(twice) > least_share * size_ * longest))
        fail("has a facet with a height below {:g} of the body's size at {}; remove it", least_share,
             show((point(a) + point(b) + point(c)) / 3));
    }
    if (!(solid_.volume > 0)) fail("has no volume");
  }

  /// Makes coordinates equal that differ by rounding, so that faces across an axis are so exactly.
  void align(std::size_t axis) {
    std::vector<double*> coordinates;
    for (Vector& p : solid_.points) coordinates.push_back(&p[axis]);
    std::ranges::sort(coordinates, {}, [](const double* one) { return *one; });
    double last = coordinates.empty() ? 0 : *coordinates.front();
    for (double* const one : coordinates) {
      if (*one - last > flatness * size_) last = *one;
      *one = last;
    }
    solid_.bounds[axis].second = last;
  }

  /// The facets beyond the three edges of each.
  void find_neighbours() {
    std::map<std::pair<int, int>, int> facet_at;  // by directed edge
    for (std::size_t f = 0; f < solid_.facets.size(); ++f)
      for (std::size_t i = 0; i < 3; ++i)
        facet_at[{solid_.facets[f][i], solid_.facets[f][(i + 1) % 3]}] = static_cast<int>(f);
    for (const auto& facet : solid_.facets) {
      auto& beyond = neighbour_.emplace_back();
      for (std::size_t i = 0; i < 3; ++i) beyond[i] = facet_at.at({facet[(i + 1) % 3], facet[i]});
    }
  }

  /// The axis along which all corners of a facet have one coordinate, or -1.
  int axis_of(std::size_t facet) const {
    const auto& [a, b, c] = solid_.facets[facet];
    for (std::size_t i = 0; i < 3; ++i)
      if (point(a)[i] == point(b)[i] && point(b)[i] == point(c)[i]) return static_cast<int>(i);
    return -1;
  }

  /// Facets in one plane, each group grown from its largest facet, whose plane it is.
  /// @param near distance from that plane [m]; axes are not told apart if it is not that of rounding
  std::vector<std::vector<std::size_t>> planes(double near, std::vector<int>& number_of) const {
    const std::size_t n = solid_.facets.size();
    std::vector<std::size_t> order(n);
    std::iota(order.begin(), order.end(), 0);
    std::ranges::stable_sort(order, std::greater<>(), [&](std::size_t f) { return area_[f]; });
    number_of.assign(n, -1);
    std::vector<std::vector<std::size_t>> members;
    for (const std::size_t seed : order) {
      if (number_of[seed] >= 0) continue;
      const int number = static_cast<int>(members.size());
      auto& own = members.emplace_back(1, seed);
      number_of[seed] = number;
      const int axis = near > flatness * size_ ? -1 : axis_of(seed);
      const Vector& origin = point(solid_.facets[seed][0]);
      const auto is_in_plane = [&](int corner) {
        return axis >= 0 ? point(corner)[index(axis)] == origin[index(axis)]
                         : std::abs(dot(normal_[seed], point(corner) - origin)) <= near;
      };
      for (std::size_t k = 0; k < own.size(); ++k)
        for (const int other : neighbour_[own[k]])
          if (const auto f = index(other); number_of[f] < 0 && group_[f] == group_[seed] &&
                                           dot(normal_[f], normal_[seed]) > same_side &&
                                           std::ranges::all_of(solid_.facets[f], is_in_plane)) {
            number_of[f] = number;
            own.push_back(f);
          }
    }
    return members;
  }

  /// Files round coordinates, often to seven digits, which bends plane faces of many facets. Points of facets
  /// in a plane up to such rounding are moved onto it; where planes meet onto their edges and corners.
  void flatten() {
    const double near = precision * std::max(size_, reach_);
    std::vector<int> plane_of;
    const auto members = planes(near, plane_of);
    std::vector<std::set<int>> at(solid_.points.size());  // planes of several facets at each point
    for (std::size_t f = 0; f < solid_.facets.size(); ++f)
      if (members[index(plane_of[f])].size() > 1)
        for (const int corner : solid_.facets[f]) at[index(corner)].insert(plane_of[f]);
    std::vector<Vector> moved = solid_.points;
    for (std::size_t i = 0; i < moved.size(); ++i) {
      Eigen::MatrixXd normals(at[i].size(), 3);
      Eigen::VectorXd height(at[i].size());
      Eigen::Index row = 0;
      for (const int plane : at[i]) {
        const std::size_t seed = members[index(plane)].front();
        for (std::size_t k = 0; k < 3; ++k) normals(row, static_cast<Eigen::Index>(k)) = normal_[seed][k];
        height[row++] = dot(normal_[seed], point(solid_.facets[seed][0]) - moved[i]);
      }
      if (row == 0 || height.cwiseAbs().maxCoeff() <= flatness * size_) continue;
      Eigen::CompleteOrthogonalDecomposition<Eigen::MatrixXd> solver;
      solver.setThreshold(1e-3);
      const Eigen::VectorXd step = solver.compute(normals).solve(height);
      if (step.norm() > 10 * near) continue;
      moved[i] = moved[i] + Vector{step[0], step[1], step[2]};
      solid_.moved = std::max(solid_.moved, step.norm());
    }
    if (solid_.moved == 0) return;
    solid_.points = std::move(moved);
    find_bounds();
    measure();
  }

  void grow_faces() {
    auto members = planes(flatness * size_, solid_.face_of);
    // Numbered by their first facets.
    for (auto& own : members) std::ranges::sort(own);
    std::ranges::sort(members, {}, [](const auto& own) { return own.front(); });
    for (const auto& own : members) {
      const auto seed = *std::ranges::max_element(own, {}, [&](std::size_t f) { return area_[f]; });
      Face face;
      face.axis = axis_of(seed);
      face.outward = normal_[seed];
      if (face.axis >= 0) {
        face.outward = {};
        face.outward[index(face.axis)] = normal_[seed][index(face.axis)] > 0 ? 1 : -1;
      }
      for (const std::size_t f : own) {
        face.area += area_[f];
        solid_.face_of[f] = static_cast<int>(solid_.faces.size());
      }
      solid_.faces.push_back(std::move(face));
    }
  }

  bool is_straight(int before, int at, int after) const {
    const Vector along = point(after) - point(before);
    return norm(cross(along, point(at) - point(before))) <= flatness * size_ * norm(along) &&
           dot(point(at) - point(before), point(after) - point(at)) > 0;
  }

  /// The edges between faces, without the points along straight ones.
  void add_edges() {
    std::map<int, std::vector<int>> ends;        // of the border edges at each point
    std::map<std::pair<int, int>, int> face_at;  // to the left of each directed border edge
    for (std::size_t f = 0; f < solid_.facets.size(); ++f)
      for (std::size_t i = 0; i < 3; ++i) {
        if (solid_.face_of[f] == solid_.face_of[index(neighbour_[f][i])]) continue;
        const int from = solid_.facets[f][i], to = solid_.facets[f][(i + 1) % 3];
        face_at[{from, to}] = solid_.face_of[f];
        ends[from].push_back(to);
      }
    // A straight piece between two corners is walked point by point.
    std::set<int> between;
    for (const auto& [at, others] : ends)
      if (others.size() == 2 && face_at.at({at, others[0]}) == face_at.at({others[1], at}) &&
          is_straight(others[0], at, others[1]))
        between.insert(at);
    for (const auto& [start, others] : ends) {
      if (between.contains(start)) continue;
      for (int at : others) {
        const int left = face_at.at({start, at});
        for (int before = start; between.contains(at);) {
          const auto& two = ends.at(at);
          before = std::exchange(at, two[0] == before ? two[1] : two[0]);
        }
        solid_.faces[index(left)].rim.push_back({start, at});
        if (start < at) solid_.edges.push_back({start, at});
      }
    }
    for (const auto& [from, to] : solid_.edges)
      if (!(norm(point(to) - point(from)) > least_share * size_))
        fail("has an edge below {:g} of the body's size at {}; remove it", least_share, show(point(from)));
  }

  /// Names from groups; of other facets by the angles between them.
  void add_names() {
    std::vector<std::uint8_t> is_named(solid_.facets.size(), 0);
    int n_parts = 0;
    for (std::size_t first = 0; first < solid_.facets.size(); ++first) {
      if (is_named[first]) continue;
      const std::string name =
          group_[first] >= 0 ? groups_[index(group_[first])] : fmt::format("face-{}", n_parts++);
      std::vector<std::size_t> own{first};
      is_named[first] = 1;
      std::set<int> faces;
      for (std::size_t k = 0; k < own.size(); ++k) {
        faces.insert(solid_.face_of[own[k]]);
        for (const int other : neighbour_[own[k]]) {
          const std::size_t f = index(other);
          const bool is_one_face = solid_.face_of[f] == solid_.face_of[own[k]];
          if (is_named[f] || group_[f] != group_[first] ||
              (!is_one_face && !(dot(normal_[f], normal_[own[k]]) > std::cos(smooth_angle))))
            continue;
          is_named[f] = 1;
          own.push_back(f);
        }
      }
      for (const int face : faces)
        if (solid_.faces[index(face)].names.empty()) solid_.faces[index(face)].names = {name};
    }
    for (Face& face : solid_.faces) {
      if (face.axis < 0) continue;
      const auto axis = index(face.axis);
      const bool is_upper = face.outward[axis] > 0;
      const double position = point(face.rim.front()[0])[axis];
      const std::string name = end_names[axis][is_upper ? 1 : 0];
      if (position == (is_upper ? solid_.bounds[axis].second : solid_.bounds[axis].first) &&
          std::ranges::find(groups_, name) == groups_.end())
        face.names.push_back(name);
    }
  }

  Solid solid_;
  std::vector<int> group_;
  std::vector<std::string> groups_;
  double metres_;
  std::string unit_;
  double size_ = 0;   ///< of the bounding box, the largest [m]
  double reach_ = 0;  ///< the largest coordinate [m]
  Vector middle_{};
  std::vector<double> area_;
  std::vector<Vector> normal_;
  std::vector<std::array<int, 3>> neighbour_;
};

}  // namespace

std::string show_place(const Vector& p, const std::string& unit) {
  return fmt::format("({:.6g}, {:.6g}, {:.6g}) {}", p[0], p[1], p[2], unit);
}

std::vector<NamedFace> named_faces(const Solid& solid) {
  std::vector<NamedFace> result;
  std::map<std::string, std::size_t> numbers;
  for (const std::size_t which : {std::size_t{0}, std::size_t{1}})
    for (const Face& face : solid.faces)
      if (face.names.size() > which && numbers.emplace(face.names[which], result.size()).second)
        result.emplace_back().name = face.names[which];
  for (std::size_t f = 0; f < solid.facets.size(); ++f) {
    const auto corner = [&](std::size_t i) { return solid.points[index(solid.facets[f][i])]; };
    const Vector vector_area = 0.5 * cross(corner(1) - corner(0), corner(2) - corner(0));
    for (const std::string& name : solid.faces[index(solid.face_of[f])].names) {
      NamedFace& named = result[numbers.at(name)];
      named.area += norm(vector_area);
      named.centre = named.centre + norm(vector_area) / 3 * (corner(0) + corner(1) + corner(2));
      named.outward = named.outward + vector_area;
    }
  }
  for (const Face& face : solid.faces)
    for (const std::string& name : face.names) ++result[numbers.at(name)].n_planes;
  for (NamedFace& named : result) {
    named.centre = named.centre / named.area;
    named.outward = named.outward / named.area;
  }
  return result;
}

Sharpness sharpest(const Solid& solid) {
  Sharpness result{2 * std::numbers::pi, {}, false};
  const auto look = [&](double angle, const Vector& place, bool is_edge) {
    if (angle < result.angle) result = {angle, place, is_edge};
  };
  std::map<std::array<int, 2>, const Face*> left;  // of each directed edge
  for (const Face& face : solid.faces) {
    std::multimap<int, int> before;
    for (const auto& [from, to] : face.rim) {
      before.emplace(to, from);
      left[{from, to}] = &face;
    }
    for (const auto& [from, to] : face.rim) {
      const Vector& corner = solid.points[index(from)];
      const Vector out = solid.points[index(to)] - corner;
      for (auto [one, end] = before.equal_range(from); one != end; ++one) {
        const Vector in = solid.points[index(one->second)] - corner;
        const double angle = std::atan2(dot(cross(out, in), face.outward), dot(out, in));
        look(angle > 0 ? angle : angle + 2 * std::numbers::pi, corner, false);
      }
    }
  }
  for (const auto& [from, to] : solid.edges) {
    const Vector &a = solid.points[index(from)], &b = solid.points[index(to)];
    const Vector one = left.at({from, to})->outward, other = left.at({to, from})->outward;
    const Vector along = (b - a) / norm(b - a);
    look(std::numbers::pi - std::atan2(dot(cross(one, other), along), dot(one, other)), (a + b) / 2, true);
  }
  return result;
}

bool contains(const Solid& solid, const Vector& p, double slack) {
  double angle = 0;  // under which the surface is seen from the point (van Oosterom and Strackee 1983)
  for (const auto& facet : solid.facets) {
    std::array<Vector, 3> to;
    std::array<double, 3> length;
    for (std::size_t i = 0; i < 3; ++i) {
      to[i] = solid.points[index(facet[i])] - p;
      length[i] = norm(to[i]);
    }
    const Vector twice = cross(to[1] - to[0], to[2] - to[0]);
    bool is_over = std::abs(dot(twice, to[0])) <= slack * norm(twice);
    for (std::size_t i = 0; i < 3; ++i) {
      const Vector side = to[(i + 1) % 3] - to[i];
      is_over = is_over && dot(cross(twice, side), to[i]) <= slack * norm(twice) * norm(side);
    }
    if (is_over) return true;
    angle += 2 * std::atan2(dot(to[0], cross(to[1], to[2])),
                            length[0] * length[1] * length[2] + dot(to[0], to[1]) * length[2] +
                                dot(to[1], to[2]) * length[0] + dot(to[2], to[0]) * length[1]);
  }
  return angle > 2 * std::numbers::pi;
}

double area_in(const Solid& solid, const std::string& name, const std::string& other,
               const std::array<std::pair<double, double>, 3>& box) {
  const auto has = [](const Face& face, const std::string& one) {
    return std::ranges::find(face.names, one) != face.names.end();
  };
  double area = 0;
  for (std::size_t f = 0; f < solid.facets.size(); ++f) {
    const Face& face = solid.faces[index(solid.face_of[f])];
    if (!has(face, name) || !has(face, other)) continue;
    std::vector<Vector> polygon;
    for (const auto corner : solid.facets[f]) polygon.push_back(solid.points[index(corner)]);
    for (std::size_t axis = 0; axis < 3; ++axis)
      for (const double side : {-1.0, 1.0}) {
        const double limit = side < 0 ? box[axis].first : box[axis].second;
        std::vector<Vector> kept;
        for (std::size_t i = 0; i < polygon.size(); ++i) {
          const Vector &p = polygon[i], &q = polygon[(i + 1) % polygon.size()];
          const double here = side * (limit - p[axis]), there = side * (limit - q[axis]);
          if (here >= 0) kept.push_back(p);
          if ((here > 0 && there < 0) || (here < 0 && there > 0))
            kept.push_back(p + here / (here - there) * (q - p));
        }
        polygon = std::move(kept);
      }
    Vector sum{};
    for (std::size_t i = 1; i + 1 < polygon.size(); ++i)
      sum = sum + cross(polygon[i] - polygon[0], polygon[i + 1] - polygon[0]);
    area += norm(sum) / 2;
  }
  return area;
}

Solid read_solid(std::string content, const std::string& extension, const std::string& unit, double metres) {
  Facets facets = read_facets(content, extension);
  check_facets(facets, unit);
  merge_points(facets);
  check_corners(facets, unit);
  std::vector<std::string> groups = facets.groups;
  Solid solid = FaceMaker(make_surface(std::move(facets), unit), std::move(groups), metres, unit).make();
  if (const Sharpness sharp = sharpest(solid); !(sharp.angle > least_angle))
    fail("has faces that lie on each other at {}; move them apart", show_place(sharp.place / metres, unit));
  solid.digest = crackle::digest_of(std::string_view(content));
  solid.content = std::move(content);
  solid.extension = extension;
  solid.unit = unit;
  solid.metres = metres;
  return solid;
}

}  // namespace crackle::solid
