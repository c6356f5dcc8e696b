// SPDX-License-Identifier: GPL-3.0-or-later
#include "geometry/mother_points.h"

#include "common/failure.h"
#include "common/index.h"
#include "common/vector.h"

#include "blue_noise.h"
#include "redraw.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <numeric>
#include <optional>
#include <utility>

namespace crackle::geometry {

namespace {

/// Points to add where tetrahedra cross the surface: where their edges intersect a face, exactly in the face,
/// or exactly on its outline if that is closer than `margin` spacings. Points closer than half a spacing to
/// an earlier one are omitted.
/// @param crossing the tetrahedra, as nodes of `points`; those that do not cross the surface are skipped
std::vector<Point> missing_face_points(const Body& body, std::span<const Point> points,
                                       std::span<const double> spacing, std::span<const Tetrahedron> crossing,
                                       double margin) {
  std::vector<Point> added;
  for (const Tetrahedron& t : crossing) {
    const std::array<Point, 4> corners{points[index(t[0])], points[index(t[1])], points[index(t[2])],
                                       points[index(t[3])]};
    if (body.classify(corners) != Containment::straddling) continue;
    Box around{corners[0], corners[0]};
    for (const Point& p : corners) around.include(p);
    for (const FaceId face : body.faces_near(around))
      for (std::size_t i = 0; i < 4; ++i)
        for (std::size_t j = 0; j < i; ++j) {
          const double local = (spacing[index(t[i])] + spacing[index(t[j])]) / 2;
          const std::optional<Point> p = body.passage(face, corners[i], corners[j], margin * local);
          if (p && body.movable(*p) != 0 && std::none_of(added.begin(), added.end(), [&](const Point& other) {
                return norm(*p - other) < 0.5 * local;
              }))
            added.push_back(*p);
        }
  }
  return added;
}

/// Sorts by the first axis, cuts into layers of one mean spacing, and sorts each layer by the remaining axes.
void sort_in_layers(const MotherPoints& points, std::span<const std::size_t> axes,
                    std::span<std::int32_t> order) {
  const auto coordinate = [&](std::int32_t i) { return points.position[index(i)][axes[0]]; };
  std::sort(order.begin(), order.end(), [&](std::int32_t a, std::int32_t b) {
    return coordinate(a) != coordinate(b) ? coordinate(a) < coordinate(b) : a < b;
  });
  if (axes.size() == 1) return;
  for (std::size_t begin = 0; begin < order.size();) {
    double sum = 0;
    std::size_t end = begin;
    for (; end < order.size(); ++end) {
      if (end > begin &&
          (coordinate(order[end]) - coordinate(order[begin])) * static_cast<double>(end - begin) > sum)
        break;
      sum += points.spacing[index(order[end])];
    }
    sort_in_layers(points, axes.subspan(1), order.subspan(begin, end - begin));
    begin = end;
  }
}

/// The points in slabs of about one local spacing across the longest edge of the body, each slab in strips
/// across the second longest one, each strip along the shortest: neighbours in space get nearby numbers.
MotherPoints in_slab_order(const MotherPoints& points, const Point& size) {
  std::array<std::size_t, 3> axes{0, 1, 2};
  std::stable_sort(axes.begin(), axes.end(), [&](std::size_t a, std::size_t b) { return size[a] > size[b]; });
  std::vector<std::int32_t> order(points.size());
  std::iota(order.begin(), order.end(), 0);
  sort_in_layers(points, axes, order);

  MotherPoints sorted;
  sorted.position.reserve(points.size());
  sorted.spacing.reserve(points.size());
  sorted.movable.reserve(points.size());
  for (const std::int32_t i : order) {
    sorted.position.push_back(points.position[index(i)]);
    sorted.spacing.push_back(points.spacing[index(i)]);
    sorted.movable.push_back(points.movable[index(i)]);
  }
  return sorted;
}

/// Minimum distance of face and interior points from edges and faces, in local spacings.
constexpr double outline_margin = 0.55;
constexpr double surface_margin = 0.5;

/// Random offset of points from equal distances on an edge, as a share of a cell, so that opposite edges
/// differ.
constexpr double edge_jitter = 0.15;

constexpr int improving_rounds = 20;
constexpr int patience = 30;
constexpr int final_rounds = 200;
constexpr double improving_radius = 0.25;  ///< in local spacings
constexpr double quality_goal = 0.5;       ///< of the base, so that few perturbed tetrahedra are bad
constexpr int max_additions = 10;          ///< maximum number of passes that add points in faces
constexpr double max_edge_length = 1e6;    ///< in spacings
// Where few cells stay bad, points are made again at a finer spacing there.
constexpr int max_refinements = 8;
constexpr std::size_t few_bad = 100;
constexpr double refinement = 0.6;

using input::max_mother_points;

enum Stream : std::uint64_t { on_edges, in_faces, in_interior, improving, choosing };

struct Collection {
  const Body& body;
  const SpacingField& spacing;
  MotherPoints points = {};
  std::vector<std::vector<std::int32_t>> of_face =
      std::vector<std::vector<std::int32_t>>(body.n_meshed_faces());

  void add(const Point& p) {
    const PlaceId place = body.place_of(p);
    for (const FaceId face : body.faces_at(place))
      if (body.in_face(face, p)) of_face[index(face)].push_back(static_cast<std::int32_t>(points.size()));
    points.position.push_back(p);
    points.spacing.push_back(spacing(p));
    points.movable.push_back(body.directions(place).mask());
  }
  SpacedPoints all() const { return {points.position, points.spacing}; }
};

/// Number of spacings from the start of an edge to each of many equidistant positions on it.
/// @throws std::runtime_error when these would be too many
std::vector<double> n_edge_spacings(const SpacingField& spacing, const Edge& edge) {
  const double length = edge.length();
  const double finest = spacing.lower_bound(edge.bounds());
  if (length / finest > max_edge_length)
    fail(
        "mesh: an edge of {:g} mm is more than {:.0e} times as long as the finest spacing on it: {}; "
        "use coarser spacings, or remove finer details",
        length * 1e3, max_edge_length, spacing.range_text());
  const auto n_steps = static_cast<std::size_t>(std::ceil(20 * length / finest));
  std::vector<double> count(n_steps + 1, 0);
  for (std::size_t i = 0; i < n_steps; ++i) {
    const Point p = edge.at((static_cast<double>(i) + 0.5) * length / static_cast<double>(n_steps));
    count[i + 1] = count[i] + length / static_cast<double>(n_steps) / spacing(p);
  }
  return count;
}

void place_on_edge(Collection& collection, const Edge& edge, RandomStream stream) {
  const std::vector<double> count = n_edge_spacings(collection.spacing, edge);
  const double step = edge.length() / static_cast<double>(count.size() - 1);
  const auto n_cells = std::max<std::int64_t>(1, std::llround(count.back()));
  for (std::int64_t cell = 1; cell < n_cells; ++cell) {
    const double wanted = count.back() *
                          (static_cast<double>(cell) + stream.uniform(-edge_jitter, edge_jitter)) /
                          static_cast<double>(n_cells);
    const auto upper = std::upper_bound(count.begin(), count.end(), wanted);
    const auto i = static_cast<std::size_t>(upper - count.begin()) - 1;
    const double share = (wanted - count[i]) / (count[i + 1] - count[i]);
    collection.add(edge.at(step * (static_cast<double>(i) + share)));
  }
}

Room room_in_face(const Body& body, FaceId id) {
  return {[&body, id](const Point& p) { return body.distance_to_outline(id, p); }, outline_margin};
}

Room room_inside(const Body& body) {
  return {[&body](const Point& p) { return body.distance_to_surface(p); }, surface_margin};
}

void place_in_face(Collection& collection, FaceId id, RandomStream stream, Crew* crew) {
  const Body& body = collection.body;
  SpacedPoints fixed;
  for (const std::int32_t i : collection.of_face[index(id)]) {
    fixed.position.push_back(collection.points.position[index(i)]);
    fixed.spacing.push_back(collection.points.spacing[index(i)]);
  }
  const Patch& patch = body.meshed_face(id).patch;
  for (const Point& p : blue_noise(collection.spacing, patch, room_in_face(body, id), fixed, stream, crew))
    collection.add(p);
}

void place_in_interior(Collection& collection, RandomStream stream, Crew* crew) {
  const Body& body = collection.body;
  for (const Point& p : blue_noise(collection.spacing, Patch{body.bounds()}, room_inside(body),
                                   collection.all(), stream, crew))
    collection.add(p);
}

/// Moves points of bad cells, first towards good shapes as far as possible, then until every cell is
/// acceptable.
/// @return the cells that stay bad; if there are more than points, which moves cannot cure, nothing is moved
std::vector<Tetrahedron> improve(const Body& body, MotherPoints& points, double goal, double min_quality,
                                 const RandomStream& stream) {
  Tessellation tessellation(body, points.position, min_quality);
  std::vector<Tetrahedron> bad = tessellation.bad_cells();
  if (bad.size() > points.size()) return bad;
  tessellation.set_min_quality(goal);
  const std::vector<Point> centre = points.position;
  const std::vector<PlaceId> place = body.places_of(centre);
  std::uint64_t pass = 0;
  const Draw draw = [&](std::int32_t node, std::int32_t number, double amplitude) {
    const auto i = static_cast<std::size_t>(node);
    return displaced(body, centre[i], place[i], amplitude * improving_radius * points.spacing[i],
                     stream.substream(pass).substream(i).substream(static_cast<std::uint64_t>(number)));
  };
  redraw(tessellation, points.movable, draw, stream.substream(choosing),
         {.max_rounds = improving_rounds, .patience = patience, .only_improve = true});
  ++pass;
  tessellation.set_min_quality(min_quality);
  RedrawOutcome outcome = redraw(tessellation, points.movable, draw, stream.substream(choosing + 1),
                                 {.max_rounds = final_rounds, .patience = patience, .shrinking = false});
  points.position.assign(tessellation.points().begin(), tessellation.points().end());
  return std::move(outcome.remaining);
}

[[noreturn]] void refuse(const Body& body, const MotherPoints& points, double min_quality,
                         const std::vector<Tetrahedron>& bad) {
  const auto corner = [&](std::size_t i) { return points.position[index(bad.front()[i])]; };
  const bool crossing =
      body.classify({corner(0), corner(1), corner(2), corner(3)}) == Containment::straddling;
  fail(
      "mesh: the body cannot be tessellated with these points: {} tetrahedra extend beyond the body or are "
      "below min_quality = {}; the first, near ({:g}, {:g}, {:g}) mm, {}; use a finer spacing there or a "
      "lower "
      "min_quality",
      bad.size(), min_quality, 1e3 * corner(0)[0], 1e3 * corner(0)[1], 1e3 * corner(0)[2],
      crossing ? "extends beyond it" : "is below min_quality");
}

/// Points that divide the longest edges of bad cells; those of edges outside the body are omitted. Where
/// inner faces meet at sharp angles, moves alone may not cure the last cells.
std::vector<Point> middles(const Body& body, const MotherPoints& points,
                           const std::vector<Tetrahedron>& bad) {
  std::vector<Point> result;
  for (const Tetrahedron& t : bad) {
    double longest = 0;
    Point middle{};
    for (std::size_t i = 0; i < 4; ++i)
      for (std::size_t j = 0; j < i; ++j) {
        const Point& a = points.position[index(t[i])];
        const Point& b = points.position[index(t[j])];
        if (norm(b - a) <= longest) continue;
        longest = norm(b - a);
        middle = 0.5 * (a + b);
      }
    const auto is_near = [&](const Point& other) { return norm(other - middle) < longest / 2; };
    if (body.contains(middle) && std::ranges::none_of(result, is_near)) result.push_back(middle);
  }
  return result;
}

/// Blue noise on edges, in faces and in the interior.
void generate(Collection& collection, const RandomStream& stream, Crew* crew) {
  const Body& body = collection.body;
  for (const Point& p : body.corners()) collection.add(p);
  std::uint64_t item = 0;
  for (const Edge& edge : body.edges())
    place_on_edge(collection, edge, stream.substream(on_edges).substream(item++));
  for (std::size_t id = 0; id < body.n_meshed_faces(); ++id)
    place_in_face(collection, static_cast<FaceId>(id), stream.substream(in_faces).substream(id), crew);
  place_in_interior(collection, stream.substream(in_interior), crew);
}

/// A lower bound on the number of points, in the interior or in one face, from the coarsest spacing there:
/// quickly detects excessive numbers.
double least_n_points(const Body& body, const SpacingField& spacing) {
  const double coarsest = spacing.upper_bound(body.bounds());
  double n = interior_density * body.volume() / (coarsest * coarsest * coarsest);
  for (std::size_t id = 0; id < body.n_meshed_faces(); ++id) {
    const Face& face = body.meshed_face(static_cast<FaceId>(id));
    const double local = spacing.upper_bound(face.patch.bounds());
    n = std::max(n, surface_density * face.area / (local * local));
  }
  return n;
}

/// An upper bound, from the finest spacing: most bodies need no count.
double most_n_points(const Body& body, const SpacingField& spacing) {
  const double finest = spacing.lower_bound(body.bounds());
  const Point size = body.size();
  double n = interior_density * size[0] * size[1] * size[2] / (finest * finest * finest);
  for (std::size_t id = 0; id < body.n_meshed_faces(); ++id)
    n += surface_density * body.meshed_face(static_cast<FaceId>(id)).area / (finest * finest);
  for (const Edge& edge : body.edges()) n += 1 + edge.length() / finest;
  return n;
}

}  // namespace

double estimate_n_points(const Body& body, const input::Mesh& mesh) {
  const SpacingField spacing(body, mesh);
  if (const double least = least_n_points(body, spacing); least > max_mother_points) return least;
  double sum = static_cast<double>(body.corners().size());
  for (const Edge& edge : body.edges()) sum += n_edge_spacings(spacing, edge).back();
  for (std::size_t i = 0; i < body.n_meshed_faces(); ++i) {
    const auto id = static_cast<FaceId>(i);
    sum +=
        expected_points(spacing, body.meshed_face(id).patch, room_in_face(body, id), max_mother_points - sum);
  }
  return sum + expected_points(spacing, Patch{body.bounds()}, room_inside(body), max_mother_points - sum);
}

double checked_n_points(const Body& body, const input::Mesh& mesh) {
  const double n_points = estimate_n_points(body, mesh);
  if (n_points > max_mother_points)
    fail(
        "mesh: more than {:.0e} mother points would be needed: {}; use coarser spacings, or remove finer "
        "details",
        max_mother_points, SpacingField(body, mesh).range_text());
  return n_points;
}

namespace {

/// @param bad the cells that stay bad; without any, the points are in their final order
MotherPoints try_points(const Body& body, const input::Mesh& mesh, const RandomStream& stream,
                        const std::function<void(double n_points)>& expects, Crew* crew,
                        std::vector<Tetrahedron>& bad) {
  const SpacingField spacing(body, mesh);
  Collection collection{body, spacing};
  if (mesh.points) {
    for (const Point& p : read_points(*mesh.points, body)) collection.add(p);
  } else {
    if (expects)
      expects(checked_n_points(body, mesh));
    else if (most_n_points(body, spacing) > max_mother_points)
      checked_n_points(body, mesh);
    const auto work = [&] { generate(collection, stream, crew); };
    if (crew)
      crew->run(mesh.regions, work);
    else
      work();
  }
  const double goal = mesh.points ? mesh.min_quality : std::max(quality_goal, mesh.min_quality);
  MotherPoints& points = collection.points;
  for (int attempt = 0;; ++attempt) {
    bad = improve(body, points, goal, mesh.min_quality,
                  stream.substream(improving).substream(static_cast<std::uint64_t>(attempt)));
    if (bad.empty()) return in_slab_order(points, body.size());
    std::vector<Point> added =
        missing_face_points(body, points.position, points.spacing, bad, outline_margin);
    if (added.empty() && !body.inner_faces().empty()) added = middles(body, points, bad);
    if (mesh.points || added.empty() || attempt == max_additions) return std::move(points);
    for (const Point& p : added) collection.add(p);
  }
}

/// A finer spacing at bad cells.
void refine(input::Mesh& mesh, const MotherPoints& points, const std::vector<Tetrahedron>& bad) {
  for (const Tetrahedron& t : bad) {
    Box box = nowhere;
    double spacing = infinity;
    for (const std::int32_t node : t) {
      box.include(points.position[index(node)]);
      spacing = std::min(spacing, points.spacing[index(node)]);
    }
    input::MeshRegion& region = mesh.regions.emplace_back();
    for (std::size_t i = 0; i < 3; ++i) region.box[i] = {box.lower[i], box.upper[i]};
    region.spacing = refinement * spacing;
  }
}

RandomStream stream_of(const input::Mesh& mesh, std::uint64_t seed, std::uint64_t sample, int attempt) {
  if (mesh.base == input::Base::shared) return {seed, 0, "mother points"};
  return {seed, sample, fmt::format("own mother points, attempt {}", attempt)};
}

}  // namespace

MotherPoints make_mother_points(const Body& body, const input::Mesh& mesh, std::uint64_t seed,
                                const std::function<void(double n_points)>& expects, std::uint64_t sample,
                                int attempt, Crew* crew) {
  const RandomStream stream = stream_of(mesh, seed, sample, attempt);
  input::Mesh finer = mesh;
  for (int n_refined = 0;; ++n_refined) {
    std::vector<Tetrahedron> bad;
    MotherPoints points = try_points(body, finer, stream, expects, crew, bad);
    if (bad.empty()) return points;
    if (mesh.points || n_refined == max_refinements || bad.size() > few_bad)
      refuse(body, points, mesh.min_quality, bad);
    refine(finer, points, bad);
  }
}

void help_mother_points(const Body& body, const input::Mesh& mesh, std::uint64_t seed, std::uint64_t sample,
                        int attempt, Crew& crew) {
  const SpacingField spacing(body, mesh);
  Collection collection{body, spacing};
  generate(collection, stream_of(mesh, seed, sample, attempt), &crew);
}

}  // namespace crackle::geometry
