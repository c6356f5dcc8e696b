// SPDX-License-Identifier: GPL-3.0-or-later
#include "solid_body.h"

#include "common/failure.h"
#include "common/index.h"
#include "common/quantity_text.h"
#include "geometry/body.h"
#include "geometry/mesh_regions.h"
#include "tolerances.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <iterator>
#include <mutex>
#include <set>
#include <string>
#include <utility>
#include <vector>

namespace crackle::geometry {

namespace {

/// Details of the body are at least this share of the spacing there.
constexpr double finest_detail = 1.0 / 50;
constexpr double most_flat_pieces = 1000;  ///< of a border, for measuring distances

/// Own axes of a face: those of the coordinates as far as they lie in its plane, else level with z.
std::array<Vector, 3> axes_of(const Vector& outward) {
  for (std::size_t i = 0; i < 3; ++i) {
    if (outward[i] != 0) continue;
    Vector along{};
    along[i] = 1;
    return {along, cross(outward, along), outward};
  }
  const Vector level{-outward[1], outward[0], 0};
  const Vector along = level / norm(level);
  return {along, cross(outward, along), outward};
}

Face face_of(const solid::Solid& solid, const solid::Face& given) {
  Face face{given.names, given.area, given.outward, {}};
  const auto corner = [&](int number) { return solid.points[index(number)]; };
  if (given.axis < 0) {
    face.patch.origin = corner(given.rim.front()[0]);
    face.patch.axes = axes_of(given.outward);
  }
  Box own = nowhere;
  for (const auto& ends : given.rim) own.include(face.patch.own(corner(ends[0])));
  if (given.axis < 0) own.lower[2] = own.upper[2] = 0;
  face.patch.domain = own;
  const auto axes = face.spanning_axes();
  for (const auto& ends : given.rim) {
    const Point from = face.patch.own(corner(ends[0])), to = face.patch.own(corner(ends[1]));
    face.rim.push_back({{{from[axes[0]], from[axes[1]]}, {to[axes[0]], to[axes[1]]}}});
  }
  return face;
}

/// A place where details of the body require a fine mesh.
struct Detail {
  Box place;
  double size;  ///< [m]
  std::string what;
};

class SolidSpacing {
public:
  explicit SolidSpacing(std::shared_ptr<const solid::Solid> solid) : solid_(std::move(solid)) {}

  void add_sources(const Body& body, const input::Mesh& mesh, std::vector<SpacingSource>& sources) const {
    std::vector<SpacingSource> given = region_sources(mesh, body.bounds());
    given.insert(given.end(), sources.begin(), sources.end());
    std::vector<SpacingSource> made;
    for (const Detail& detail : *details(body, mesh.spacing)) {
      const Point middle = 0.5 * (detail.place.lower + detail.place.upper);
      double spacing = mesh.spacing;
      for (const SpacingSource& source : given) spacing = std::min(spacing, source.at(middle));
      if (detail.size < finest_detail * spacing)
        fail(
            "specimen.solid: {} at ({:.6g}, {:.6g}, {:.6g}) mm is {}, less than a fiftieth of the spacing "
            "there; "
            "remove such details, or give a finer spacing",
            detail.what, 1e3 * middle[0], 1e3 * middle[1], 1e3 * middle[2], quantity_text(detail.size, "m"));
      for (const SpacingSource& source : made) {
        double gap = 0;
        for (std::size_t i = 0; i < 3; ++i)
          gap = std::max({gap, source.region.lower[i] - middle[i], middle[i] - source.region.upper[i]});
        if (source.spacing + source.growth * gap < spacing) spacing = std::min(spacing, source.at(middle));
      }
      if (detail.size * fine_enough < spacing)
        made.push_back({detail.place, detail.size, shape_growth(mesh), detail.what});
    }
    std::ranges::move(made, std::back_inserter(sources));
  }

private:
  using Details = std::vector<Detail>;

  /// Those that may be finer than a spacing, the finest first, as they make most of the others superfluous.
  std::shared_ptr<const Details> details(const Body& body, double spacing) const {
    const std::scoped_lock lock(mutex_);
    if (known_ && known_at_ == spacing) return known_;
    Details found = edge_lengths();
    for (std::size_t id = 0; id < body.faces().size(); ++id)
      add_gaps(body, static_cast<FaceId>(id), spacing, found);
    std::ranges::stable_sort(found, {}, &Detail::size);
    known_at_ = spacing;
    known_ = std::make_shared<const Details>(std::move(found));
    return known_;
  }

  std::vector<Detail> edge_lengths() const {
    std::vector<Detail> details;
    for (const auto& [from, to] : solid_->edges) {
      const Edge edge(solid_->points[index(from)], solid_->points[index(to)]);
      details.push_back({edge.bounds(), edge.length(), "the length of an edge"});
    }
    return details;
  }

  /// The faces that have a corner in common with a face.
  static std::set<FaceId> touching(const Body& body, const solid::Solid& solid, const solid::Face& face) {
    std::set<FaceId> faces;
    for (const auto& ends : face.rim)
      for (const FaceId other : body.faces_at(body.place_of(solid.points[index(ends[0])])))
        faces.insert(other);
    return faces;
  }

  /// The distances of a face's sides from each other, and of places in it from other faces.
  void add_gaps(const Body& body, FaceId id, double spacing, std::vector<Detail>& details) const {
    const Face& face = body.faces()[index(id)];
    const auto& ends = solid_->faces[index(id)].rim;
    const auto axes = face.spanning_axes();
    const std::set<FaceId> beside = touching(body, *solid_, solid_->faces[index(id)]);
    const auto is_other = [&](FaceId other) { return !beside.contains(other); };
    const auto place_of = [&](const plane::Point& own) {
      Point full = face.patch.domain.lower;
      for (std::size_t k = 0; k < 2; ++k) full[axes[k]] = own[k];
      return face.patch.at(full);
    };
    const auto add = [&](const plane::Point& lower, const plane::Point& upper, double size,
                         const char* what) {
      Box place = nowhere;
      for (const plane::Point& own : {lower, upper, {lower[0], upper[1]}, {upper[0], lower[1]}})
        place.include(place_of(own));
      if (size < spacing) details.push_back({place, size, fmt::format("{} {}", what, face.names.front())});
    };
    for (std::size_t s = 0; s < ends.size(); ++s) {
      const auto& [from, to] = face.rim[s];
      const double n_pieces =
          std::clamp(std::ceil(plane::distance(from, to, to) / spacing), 1.0, most_flat_pieces);
      for (double piece = 0; piece < n_pieces; ++piece) {
        const plane::Point a = plane::between(from, to, piece / n_pieces);
        const plane::Point b = plane::between(from, to, (piece + 1) / n_pieces);
        double width = spacing;
        for (std::size_t t = 0; t < ends.size(); ++t) {
          const bool meet = ends[s][0] == ends[t][0] || ends[s][0] == ends[t][1] ||
                            ends[s][1] == ends[t][0] || ends[s][1] == ends[t][1];
          if (!meet) width = std::min(width, plane::distance(a, b, face.rim[t][0], face.rim[t][1]));
        }
        const plane::Point lower{std::min(a[0], b[0]), std::min(a[1], b[1])},
            upper{std::max(a[0], b[0]), std::max(a[1], b[1])};
        add(lower, upper, width, "the width of");
        add(lower, upper, body.distance_to_faces(place_of(plane::between(a, b, 0.5)), spacing, is_other),
            "the thickness of the body or of a gap at");
      }
    }
    // Places in the face, about one spacing apart.
    std::array<double, 2> step{};
    std::array<int, 2> n{};
    for (std::size_t k = 0; k < 2; ++k) {
      const double extent = face.patch.domain.upper[axes[k]] - face.patch.domain.lower[axes[k]];
      n[k] = static_cast<int>(std::floor(extent / spacing));
      step[k] = extent / std::max(n[k], 1);
    }
    for (int i = 0; i < n[0]; ++i)
      for (int j = 0; j < n[1]; ++j) {
        const plane::Point lower{face.patch.domain.lower[axes[0]] + i * step[0],
                                 face.patch.domain.lower[axes[1]] + j * step[1]};
        const plane::Point upper{lower[0] + step[0], lower[1] + step[1]};
        const Point p = place_of(plane::between(lower, upper, 0.5));
        if (!body.in_face(id, p)) continue;
        add(lower, upper, body.distance_to_faces(p, spacing, is_other),
            "the thickness of the body or of a gap at");
      }
  }

  std::shared_ptr<const solid::Solid> solid_;
  // The last ones, which take longer than what follows from them.
  mutable std::mutex mutex_;
  mutable std::shared_ptr<const Details> known_;
  mutable double known_at_ = 0;
};

}  // namespace

Complex solid_complex(const std::shared_ptr<const solid::Solid>& solid) {
  Complex complex;
  for (std::size_t i = 0; i < 3; ++i) {
    complex.bounds.lower[i] = solid->bounds[i].first;
    complex.bounds.upper[i] = solid->bounds[i].second;
  }
  complex.volume = solid->volume;
  std::set<int> corners;
  for (const auto& [from, to] : solid->edges) {
    complex.edges.emplace_back(solid->points[index(from)], solid->points[index(to)]);
    corners.insert({from, to});
  }
  for (const int corner : corners) complex.corners.push_back(solid->points[index(corner)]);
  for (const solid::Face& face : solid->faces) complex.faces.push_back(face_of(*solid, face));
  complex.spacing_rules.push_back(
      [spacing = std::make_shared<const SolidSpacing>(solid)](const Body& body, const input::Mesh& mesh,
                                                              std::vector<SpacingSource>& sources) {
        spacing->add_sources(body, mesh, sources);
      });
  return complex;
}

}  // namespace crackle::geometry
