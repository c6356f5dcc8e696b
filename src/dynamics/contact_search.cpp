// SPDX-License-Identifier: GPL-3.0-or-later
#include "contact_search.h"

#include "common/index.h"
#include "geometry/box.h"
#include "parallel/agreement.h"
#include "parallel/collectives.h"

#include <algorithm>
#include <cmath>
#include <utility>

namespace crackle::dynamics {

namespace {

/// Share of a tetrahedron's height up to which a node counts as below its face.
constexpr double largest_depth = 0.5;
/// Longest edges within which a node and a face were neighbours before anything moved.
constexpr double neighbourhood = 2;
/// Share of the longest edge above a face's plane from which on a node is in front of it.
constexpr double in_front = 1e-6;

/// A face of an unbroken tetrahedron without an unbroken neighbour.
struct SurfaceFace {
  ContactPair pair;                // without a node
  std::array<Vector, 3> at_start;  // places of its corners
  std::array<Vector, 3> now;
  // Unit normals of these, once complete, and the longest edge at the start.
  Vector normal_at_start{}, normal{};
  double longest = 0;
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

Surface find_surface(const fracture::BreakableBody& body, std::span<const Vector> displacement) {
  const geometry::Subdomain& part = body.subdomain();
  const auto& neighbours = body.face_neighbours();
  Surface surface{{}, std::vector<std::uint8_t>(part.nodes.size(), 0)};
  for (std::size_t t = 0; t < part.tetrahedra.size(); ++t) {
    const geometry::Tetrahedron& corners = part.tetrahedra[t];
    if (body.is_broken(static_cast<std::int32_t>(t))) {
      for (const auto node : corners) surface.is_on[index(node)] = 1;
      continue;
    }
    std::int64_t open = 0;
    for (std::size_t c = 0; c < 4; ++c)
      if (const auto other = neighbours[t][c]; other < 0 || body.is_broken(other))
        open |= std::int64_t{1} << c;
    for (std::size_t c = 0; open != 0 && c < 4; ++c) {
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
        face.at_start[a] = part.nodes[index(nodes[a])];
        face.now[a] = face.at_start[a] + displacement[index(nodes[a])];
      }
      const Vector n = normal_of(face.at_start);
      face.pair.depth = largest_depth * dot(n, face.at_start[0] - part.nodes[index(nodes[3])]);
    }
  }
  return surface;
}

/// Sorts the faces of all ranks, measures them, and finds which others of their tetrahedra belong to the
/// surface.
void complete(std::vector<SurfaceFace>& faces) {
  std::ranges::sort(faces, {}, [](const SurfaceFace& face) { return face.pair.face; });
  for (std::size_t begin = 0, end = 0; begin < faces.size(); begin = end) {
    const std::int64_t tetrahedron = faces[begin].pair.face / 4;
    std::array<bool, 4> is_open{};
    for (; end < faces.size() && faces[end].pair.face / 4 == tetrahedron; ++end)
      is_open[index(faces[end].pair.face % 4)] = true;
    for (std::size_t f = begin; f < end; ++f) {
      SurfaceFace& face = faces[f];
      face.normal_at_start = normal_of(face.at_start);
      face.normal = normal_of(face.now);
      for (std::size_t a = 0; a < 3; ++a) {
        face.longest = std::max(face.longest, norm(face.at_start[(a + 1) % 3] - face.at_start[a]));
        if (is_open[face_corners[index(face.pair.face % 4)][a]]) face.pair.open |= std::int64_t{1} << a;
      }
    }
  }
}

geometry::Box box_of(const SurfaceFace& face) {
  geometry::Box box = geometry::nowhere;
  for (const Vector& corner : face.now) box.include(corner);
  return box;
}

/// A grid of cubes that lists the faces near each of them.
class FaceGrid {
public:
  FaceGrid(std::span<const SurfaceFace> faces, double margin) : faces_(faces), margin_(margin) {
    double sum = 0;
    for (const SurfaceFace& face : faces) {
      geometry::Box& box = boxes_.emplace_back(box_of(face));
      sum += std::ranges::max(box.upper - box.lower);
      for (std::size_t i = 0; i < 3; ++i) {
        box.lower[i] -= reach(face);
        box.upper[i] += reach(face);
      }
    }
    // Larger cells list more faces, smaller ones list each face more often.
    size_ = 3 * margin + (faces.empty() ? 0 : 1.5 * sum / static_cast<double>(faces.size()));
    for (std::size_t f = 0; f < faces.size(); ++f) {
      std::array<std::int64_t, 3> low{}, high{};
      for (std::size_t i = 0; i < 3; ++i) {
        low[i] = cell(boxes_[f].lower[i]);
        high[i] = cell(boxes_[f].upper[i]);
      }
      for (std::int64_t x = low[0]; x <= high[0]; ++x)
        for (std::int64_t y = low[1]; y <= high[1]; ++y)
          for (std::int64_t z = low[2]; z <= high[2]; ++z) entries_.push_back({key(x, y, z), f});
    }
    std::ranges::sort(entries_);
  }

  /// Calls a function for all faces whose box a point is in.
  template <class Visit>
  void near(const Vector& x, const Visit& visit) const {
    const auto place = key(cell(x[0]), cell(x[1]), cell(x[2]));
    for (auto entry = std::ranges::lower_bound(entries_, std::pair<std::uint64_t, std::size_t>{place, 0});
         entry != entries_.end() && entry->first == place; ++entry)
      if (boxes_[entry->second].contains(x)) visit(faces_[entry->second]);
  }

  double reach(const SurfaceFace& face) const { return margin_ + face.pair.depth; }

private:
  std::int64_t cell(double x) const { return static_cast<std::int64_t>(std::floor(x / size_)); }
  /// 21 bits of each number: cells that share a key by accident cost time only.
  static std::uint64_t key(std::int64_t x, std::int64_t y, std::int64_t z) {
    constexpr std::uint64_t digits = (1U << 21U) - 1;
    const auto part = [](std::int64_t i) { return static_cast<std::uint64_t>(i) & digits; };
    return part(x) << 42U | part(y) << 21U | part(z);
  }

  std::span<const SurfaceFace> faces_;
  double margin_;
  std::vector<geometry::Box> boxes_;  // of the faces and all that is within their reach
  double size_;
  std::vector<std::pair<std::uint64_t, std::size_t>> entries_;
};

}  // namespace

std::vector<ContactPair> find_contact_pairs(const parallel::Communicator& group,
                                            const fracture::BreakableBody& body,
                                            std::span<const Vector> displacement, double margin) {
  const geometry::Subdomain& part = body.subdomain();
  const Surface mine = parallel::agree(group, [&] { return find_surface(body, displacement); });
  auto faces = parallel::gather_all<SurfaceFace>(group, mine.faces);
  const auto pairs = parallel::agree(group, [&] {
    complete(faces);
    const FaceGrid grid(faces, margin);
    std::vector<ContactPair> found;
    for (std::int32_t n = 0; n < part.layout.n_owned; ++n) {
      if (mine.is_on[index(n)] == 0) continue;
      const Vector& start = part.nodes[index(n)];
      const Vector now = start + displacement[index(n)];
      const std::int64_t number = part.layout.number[index(n)];
      grid.near(now, [&](const SurfaceFace& face) {
        const double reach = grid.reach(face);
        if (std::ranges::find(face.pair.corners, number) != face.pair.corners.end()) return;
        const double height = dot(face.normal, now - face.now[0]);
        // Also false for a face without an area.
        if (!(height < margin && height > -reach)) return;
        const Vector off = start - face.at_start[0];
        if (norm(off) < neighbourhood * face.longest &&
            dot(face.normal_at_start, off) <= in_front * face.longest)
          return;
        ContactPair pair = face.pair;
        pair.node = number;
        // Before they may touch, the node has to pass the face's plane, or its edges.
        pair.gap = std::max(height, -height - face.pair.depth);
        const geometry::Box box = box_of(face);
        for (std::size_t i = 0; i < 3; ++i) {
          const double beyond = 2 * found_beyond * (box.upper[i] - box.lower[i]);
          pair.gap = std::max({pair.gap, box.lower[i] - now[i] - beyond, now[i] - box.upper[i] - beyond});
        }
        found.push_back(pair);
      });
    }
    return found;
  });
  auto all = parallel::gather_all<ContactPair>(group, pairs);
  std::ranges::sort(all, [](const auto& a, const auto& b) { return a < b; });
  return all;
}

}  // namespace crackle::dynamics
