// SPDX-License-Identifier: GPL-3.0-or-later
#include "contact_search.h"

#include "common/index.h"
#include "geometry/box.h"
#include "parallel/agreement.h"
#include "parallel/collectives.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <numeric>
#include <utility>

namespace crackle::dynamics {

namespace {

/// Share of a tetrahedron's height up to which a node counts as below its face.
constexpr double largest_depth = 0.5;
/// Longest edges within which a node and a face were neighbours before anything moved.
constexpr double neighbourhood = 2;
/// Share of the longest edge above a face's plane from which on a node is in front of it.
constexpr double in_front = 1e-6;

geometry::Box box_of(const std::array<Vector, 3>& face) {
  geometry::Box box = geometry::nowhere;
  for (const Vector& corner : face) box.include(corner);
  return box;
}

/// A face of an unbroken tetrahedron without an unbroken neighbour.
struct SurfaceFace {
  ContactPair pair;                // without a node
  std::array<Vector, 3> at_start;  // places of its corners
  std::array<Vector, 3> now;
  bool is_fast;  // any of them

  double longest_edge() const {  // at the start
    double longest = 0;
    for (std::size_t a = 0; a < 3; ++a)
      longest = std::max(longest, norm(at_start[(a + 1) % 3] - at_start[a]));
    return longest;
  }
  /// The place of all nodes closer than a margin.
  geometry::Box box(double margin) const {
    geometry::Box box = box_of(now);
    for (std::size_t i = 0; i < 3; ++i) {
      box.lower[i] -= margin + pair.depth;
      box.upper[i] += margin + pair.depth;
    }
    return box;
  }
};

/// Vertices of the face opposite each corner of a tetrahedron, seen counterclockwise from outside.
constexpr std::array<std::array<std::size_t, 3>, 4> face_corners{
    {{1, 2, 3}, {0, 3, 2}, {0, 1, 3}, {0, 2, 1}}};

Vector normal_of(const std::array<Vector, 3>& x) {
  const Vector area = cross(x[1] - x[0], x[2] - x[0]);
  return area / norm(area);
}

/// The surface as seen by one rank.
struct Surface {
  std::vector<SurfaceFace> faces;   // each reported by the owner of its node of the least number
  std::vector<std::uint8_t> is_on;  // of each owned node: 1 for those of a face or a broken tetrahedron
};

/// The faces of each local tetrahedron without an unbroken neighbour: bit k is that opposite corner k.
std::vector<std::uint8_t> open_faces(const fracture::BreakableBody& body) {
  const auto& neighbours = body.face_neighbours();
  std::vector<std::uint8_t> open(neighbours.size(), 0);
  const auto add = [&](std::size_t t, std::size_t c) {
    open[t] = static_cast<std::uint8_t>(open[t] | 1U << c);
  };
  for (std::size_t t = 0; t < neighbours.size(); ++t)
    for (std::size_t c = 0; c < 4; ++c)
      if (neighbours[t][c] < 0) add(t, c);
  for (const std::int32_t broken : body.broken_tetrahedra())
    for (const std::int32_t other : neighbours[index(broken)])
      for (std::size_t c = 0; other >= 0 && c < 4; ++c)
        if (neighbours[index(other)][c] == broken) add(index(other), c);
  return open;
}

Surface find_surface(const fracture::BreakableBody& body, std::span<const Vector> displacement,
                     std::span<const std::uint8_t> is_fast) {
  const geometry::Subdomain& part = body.subdomain();
  Surface surface{{}, std::vector<std::uint8_t>(part.nodes.size(), 0)};
  const auto all_open = open_faces(body);
  std::size_t n_faces = 0;
  for (const std::uint8_t open : all_open) n_faces += static_cast<std::size_t>(std::popcount(open));
  surface.faces.reserve(n_faces);
  for (const std::int32_t broken : body.broken_tetrahedra())
    for (const auto node : part.tetrahedra[index(broken)]) surface.is_on[index(node)] = 1;
  for (std::size_t t = 0; t < part.tetrahedra.size(); ++t) {
    const std::uint8_t open = all_open[t];
    if (open == 0 || body.is_broken(static_cast<std::int32_t>(t))) continue;
    const geometry::Tetrahedron& corners = part.tetrahedra[t];
    for (std::size_t c = 0; c < 4; ++c) {
      if (((open >> c) & 1) == 0) continue;
      const auto& [i, j, k] = face_corners[c];
      const std::array<std::int32_t, 4> nodes{corners[i], corners[j], corners[k], corners[c]};
      const auto number = [&](std::size_t a) { return part.layout.number[index(nodes[a])]; };
      const std::size_t least =
          number(0) < number(1) ? (number(0) < number(2) ? 0 : 2) : (number(1) < number(2) ? 1 : 2);
      // Only a rank that owns one of its nodes knows whether a face has a neighbour.
      const auto is_mine = [&](std::size_t a) { return nodes[a] < part.layout.n_owned; };
      if (!is_mine(0) && !is_mine(1) && !is_mine(2)) continue;
      for (std::size_t a = 0; a < 3; ++a) surface.is_on[index(nodes[a])] = 1;
      if (!is_mine(least)) continue;
      SurfaceFace& face = surface.faces.emplace_back();
      face.pair = {0,
                   4 * part.tetrahedron_number[t] + static_cast<std::int64_t>(c),
                   {number(0), number(1), number(2), number(3)},
                   0,
                   0};
      for (std::size_t a = 0; a < 3; ++a) {
        face.is_fast = face.is_fast || is_fast[index(nodes[a])] != 0;
        face.at_start[a] = part.nodes[index(nodes[a])];
        face.now[a] = face.at_start[a] + displacement[index(nodes[a])];
      }
      const Vector n = normal_of(face.at_start);
      face.pair.depth = largest_depth * dot(n, face.at_start[0] - part.nodes[index(nodes[3])]);
    }
  }
  return surface;
}

/// Sorts the faces of all ranks, and finds which others of their tetrahedra belong to the surface.
void complete(std::vector<SurfaceFace>& faces) {
  std::ranges::sort(faces, {}, [](const SurfaceFace& face) { return face.pair.face; });
  for (std::size_t begin = 0, end = 0; begin < faces.size(); begin = end) {
    const std::int64_t tetrahedron = faces[begin].pair.face / 4;
    std::array<bool, 4> is_open{};
    for (; end < faces.size() && faces[end].pair.face / 4 == tetrahedron; ++end)
      is_open[index(faces[end].pair.face % 4)] = true;
    for (std::size_t f = begin; f < end; ++f) {
      SurfaceFace& face = faces[f];
      for (std::size_t a = 0; a < 3; ++a)
        if (is_open[face_corners[index(face.pair.face % 4)][a]]) face.pair.open |= std::int64_t{1} << a;
    }
  }
}

/// Points in a grid of cubes.
class PointGrid {
public:
  PointGrid(std::span<const Vector> points, double size)
      : size_(size), first_(2 * std::bit_ceil(points.size() + 1) + 1, 0) {
    const auto key_of = [this](const Vector& x) { return key(cell(x[0]), cell(x[1]), cell(x[2])); };
    for (const Vector& x : points) ++first_[bucket(key_of(x)) + 1];
    std::partial_sum(first_.begin(), first_.end(), first_.begin());
    entries_.resize(points.size());
    auto next = first_;
    for (std::size_t i = 0; i < points.size(); ++i) {
      const std::uint64_t place = key_of(points[i]);
      entries_[next[bucket(place)]++] = {place, points[i], i};
    }
  }

  /// Calls a function for all points in a box.
  template <class Visit>
  void for_points(const geometry::Box& box, const Visit& visit) const {
    std::array<std::int64_t, 3> low{}, high{};
    for (std::size_t i = 0; i < 3; ++i) {
      low[i] = cell(box.lower[i]);
      high[i] = cell(box.upper[i]);
    }
    for (std::int64_t x = low[0]; x <= high[0]; ++x)
      for (std::int64_t y = low[1]; y <= high[1]; ++y)
        for (std::int64_t z = low[2]; z <= high[2]; ++z) {
          const std::uint64_t place = key(x, y, z);
          for (std::size_t e = first_[bucket(place)]; e < first_[bucket(place) + 1]; ++e)
            if (entries_[e].cell == place && box.contains(entries_[e].x)) visit(entries_[e].point);
        }
  }

private:
  struct Entry {
    std::uint64_t cell;
    Vector x;
    std::size_t point;
  };
  std::int64_t cell(double x) const { return static_cast<std::int64_t>(std::floor(x / size_)); }
  /// 21 bits of each number: cells that share a key by accident cost time only.
  static std::uint64_t key(std::int64_t x, std::int64_t y, std::int64_t z) {
    constexpr std::uint64_t digits = (1U << 21U) - 1;
    const auto part = [](std::int64_t i) { return static_cast<std::uint64_t>(i) & digits; };
    return part(x) << 42U | part(y) << 21U | part(z);
  }
  /// By the high digits of a product with the golden ratio, which scatter.
  std::size_t bucket(std::uint64_t cell) const {
    return static_cast<std::size_t>(cell * 0x9e3779b97f4a7c15U >> 32U) & (first_.size() - 2);
  }

  double size_;
  std::vector<std::size_t> first_;  // entry of each bucket, and their number
  std::vector<Entry> entries_;      // by buckets
};

/// Nodes of the surface, of one rank.
struct SurfaceNodes {
  std::vector<std::int32_t> local;
  std::vector<Vector> now;
};

/// Those that are fast, or the others.
SurfaceNodes find_nodes(const geometry::Subdomain& part, const Surface& surface,
                        std::span<const Vector> displacement, std::span<const std::uint8_t> is_fast,
                        bool fast) {
  SurfaceNodes nodes;
  for (std::int32_t n = 0; n < part.layout.n_owned; ++n) {
    if (surface.is_on[index(n)] == 0 || (is_fast[index(n)] != 0) != fast) continue;
    nodes.local.push_back(n);
    nodes.now.push_back(part.nodes[index(n)] + displacement[index(n)]);
  }
  return nodes;
}

/// @param margin_of a face, with these nodes [m]
void add_pairs(const geometry::Subdomain& part, const SurfaceNodes& nodes, std::span<const SurfaceFace> faces,
               const auto& margin_of, std::vector<ContactPair>& found) {
  if (nodes.local.empty() || faces.empty()) return;
  double sum = 0;
  for (const SurfaceFace& face : faces) {
    const geometry::Box box = face.box(margin_of(face));
    sum += std::ranges::max(box.upper - box.lower);
  }
  // Larger cells hold more points, smaller ones are more to look into.
  const PointGrid grid(nodes.now, 0.8 * sum / static_cast<double>(faces.size()));
  for (const SurfaceFace& face : faces) {
    const Vector normal = normal_of(face.now), normal_at_start = normal_of(face.at_start);
    const double longest = face.longest_edge(), margin = margin_of(face);
    grid.for_points(face.box(margin), [&](std::size_t point) {
      const auto node = index(nodes.local[point]);
      const std::int64_t number = part.layout.number[node];
      if (std::ranges::find(face.pair.corners, number) != face.pair.corners.end()) return;
      const Vector off = part.nodes[node] - face.at_start[0];
      if (norm(off) < neighbourhood * longest && dot(normal_at_start, off) <= in_front * longest) return;
      ContactPair pair = face.pair;
      pair.node = number;
      pair.gap = contact_gap(nodes.now[point], face.now, normal, face.pair.depth);
      // Also false for a face without an area.
      if (pair.gap < margin) found.push_back(pair);
    });
  }
}

}  // namespace

double contact_gap(const Vector& node, const std::array<Vector, 3>& face, const Vector& normal,
                   double depth) {
  // The node has to enter the prism below the face.
  const double height = dot(normal, node - face[0]);
  double gap = std::max(height, -height - depth);
  geometry::Box box = box_of(face);
  for (const Vector& corner : face) box.include(corner - depth * normal);
  for (std::size_t i = 0; i < 3; ++i) {
    const double beyond = 2 * found_beyond * (box.upper[i] - box.lower[i]);
    gap = std::max({gap, box.lower[i] - node[i] - beyond, node[i] - box.upper[i] - beyond});
  }
  return gap;
}

std::vector<ContactPair> find_contact_pairs(const parallel::Communicator& group,
                                            const fracture::BreakableBody& body,
                                            std::span<const Vector> displacement,
                                            const ContactMargins& margins) {
  const geometry::Subdomain& part = body.subdomain();
  Surface mine = parallel::agree(group, [&] { return find_surface(body, displacement, margins.is_fast); });
  auto faces =
      group.size() > 1 ? parallel::gather_all<SurfaceFace>(group, mine.faces) : std::move(mine.faces);
  const auto pairs = parallel::agree(group, [&] {
    complete(faces);
    std::vector<ContactPair> found;
    const auto margin = [&](bool fast) { return fast ? margins.of_fast : margins.of_most; };
    for (const bool fast : {false, true})
      add_pairs(
          part, find_nodes(part, mine, displacement, margins.is_fast, fast), faces,
          [&](const SurfaceFace& face) { return 0.5 * (margin(fast) + margin(face.is_fast)); }, found);
    return found;
  });
  auto all = parallel::gather_all<ContactPair>(group, pairs);
  std::ranges::sort(all, [](const auto& a, const auto& b) { return a < b; });
  return all;
}

}  // namespace crackle::dynamics
