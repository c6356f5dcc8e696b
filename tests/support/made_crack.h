// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "common/index.h"
#include "common/random.h"
#include "cracks/crack_surface.h"

#include "support/structured_mesh.h"

#include <algorithm>
#include <cmath>
#include <functional>
#include <limits>
#include <numbers>
#include <utility>
#include <vector>

namespace crackle::test {

/// A normally distributed number.
inline double normal(RandomStream& stream) {
  const double u = 1 - stream.uniform();
  return std::sqrt(-2 * std::log(u)) * std::cos(2 * std::numbers::pi * stream.uniform());
}

/// A crack with a known path and front in a plate 24.5 mm wide, from a notch 5.5 mm deep at y-min to the
/// opposite face, in a structured mesh of tetrahedra whose nodes are displaced at random.
///
/// The mesh's cubes have edges of 1 m; lengths here are in mm, and a cube's edge is mm() long.
class MadeCrack {
public:
  static constexpr double width = 24.5;  // [mm]
  static constexpr double depth = 5.5;
  using Path = std::function<double(double advance)>;

  struct Tetrahedron {
    double x;        ///< relative position of the centroid in the thickness
    double advance;  ///< of the centroid from the tip [mm]
    double least;    ///< smallest advance of its nodes [mm]
    double side;     ///< of the centroid from the path, in the direction of z [mm]
  };
  /// When a tetrahedron breaks [s]; negative: it does not.
  using Time = std::function<double(const Tetrahedron&, RandomStream& noise)>;

  /// @param spacing mean local spacing of the facets [mm]
  /// @param path z - plane over the advance from the tip [mm]
  /// @param low,high smallest and largest z - plane [mm]
  MadeCrack(
      double spacing, double thickness, std::uint64_t seed, Path path = [](double) { return 0.0; },
      double low = 0, double high = 0)
      : mm_(spacing / spacing_of_cube),
        seed_(seed),
        path_(std::move(path)),
        plane_(std::ceil((tilt * thickness / 2 - low) / mm_) + 4.5),
        mesh_({{std::max(1.0, std::round(thickness / mm_)), std::round(width / mm_),
                std::ceil((tilt * thickness / 2 + high) / mm_) + plane_ + 4.5},
               {{plane::Face::y_min, plane_, std::round(depth / mm_), 1}}},
              [&](const geometry::Point& centre) {
                // Cubes at the notch and along the path: where the path is steep it passes several in a row.
                const double advance = advance_of(centre);
                if (advance < 0) return std::abs(centre[2] - plane_) < 3;
                const auto ends = std::minmax({z_of(centre[0], advance - 1.5 * mm_), z_of(centre[0], advance),
                                               z_of(centre[0], advance + 1.5 * mm_)});
                return centre[2] > ends.first - 2 && centre[2] < ends.second + 2;
              }) {
    mesh_.map_nodes([&](geometry::Point p) { return displaced(p); });
    breaks_ = mesh_.break_between(
        [&](const geometry::Point& p) {
          const geometry::Point q = displaced(p);
          return q[2] > z_of(q[0], advance_of(q)) ? 1 : 0;
        },
        [&](const geometry::Point& p) { return advance_of(p) > 0 ? 0.0 : -1.0; });
  }

  double mm() const { return mm_; }
  double plane() const { return plane_; }  ///< z of the notch
  const geometry::Body& body() const { return mesh_.body(); }

  cracks::CrackSurface surface(
      const Time& time = [](const Tetrahedron& t, RandomStream&) { return t.advance; },
      std::uint64_t noise = 0) const {
    std::vector<fracture::Break> breaks;
    const RandomStream all(seed_, noise, "noise");
    for (fracture::Break broken : breaks_) {
      Tetrahedron t{0, 0, std::numeric_limits<double>::infinity(), 0};
      for (const auto node : mesh_.realization().tetrahedra[index(broken.tetrahedron)]) {
        const geometry::Point& p = mesh_.realization().nodes[index(node)];
        t.x += p[0] / body().size()[0] / 4;
        t.advance += advance_of(p) / 4;
        t.least = std::min(t.least, advance_of(p));
        t.side += (p[2] - z_of(p[0], advance_of(p))) * mm_ / 4;
      }
      auto stream = all.substream(static_cast<std::uint64_t>(broken.tetrahedron));
      broken.phase_time = time(t, stream);
      if (broken.phase_time >= 0) breaks.push_back(broken);
    }
    std::stable_sort(breaks.begin(), breaks.end(),
                     [](const auto& a, const auto& b) { return a.phase_time < b.phase_time; });
    return cracks::make_crack_surface(body(), mesh_.realization(), breaks, 0);
  }

private:
  static constexpr double spacing_of_cube =
      1.3;  // mean local spacing of the facets relative to the cubes' edge
  /// Tilt of the crack through the thickness, so that it meets the cube layers at all heights.
  static constexpr double tilt = 0.3;

  double advance_of(const geometry::Point& p) const { return (p[1] - std::round(depth / mm_)) * mm_; }
  double z_of(double x, double advance) const {
    return plane_ + path_(std::max(advance, 0.0)) / mm_ + tilt * (x - body().size()[0] / 2);
  }

  /// Displaced uniformly in a cube; no node leaves the plate's sides or the notch.
  geometry::Point displaced(geometry::Point p) const {
    constexpr double largest = 0.25;
    if (advance_of(p) <= 0) return p;
    auto stream = RandomStream(seed_, 0, "nodes")
                      .substream(static_cast<std::uint64_t>(p[0]))
                      .substream(static_cast<std::uint64_t>(p[1]))
                      .substream(static_cast<std::uint64_t>(p[2]));
    for (std::size_t i = 0; i < 3; ++i) {
      const double by = stream.uniform(-largest, largest);
      if (i == 0 && (p[0] == 0 || p[0] == body().size()[0])) continue;
      if (i == 1 && p[1] == body().size()[1]) continue;
      p[i] += by;
    }
    return p;
  }

  double mm_;
  std::uint64_t seed_;
  Path path_;
  double plane_;
  StructuredMesh mesh_;
  std::vector<fracture::Break> breaks_;
};

}  // namespace crackle::test
