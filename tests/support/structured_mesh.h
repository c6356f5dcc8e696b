// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "common/index.h"
#include "fracture/break_record.h"
#include "geometry/body.h"
#include "geometry/realization.h"

#include <algorithm>
#include <array>
#include <functional>
#include <map>
#include <utility>
#include <vector>

namespace crackle::test {

/// A notched box of unit cubes [m], each cut into six tetrahedra around a space diagonal (Kuhn's
/// subdivision), and breaks along given surfaces in it. The subdivision is symmetric about the cube centres,
/// so a crack along a plane through them has its mean position exactly on that plane.
class StructuredMesh {
public:
  /// @param keep selects cubes of the box by their centre; all without it
  explicit StructuredMesh(plane::Specimen specimen,
                          const std::function<bool(const geometry::Point&)>& keep = {})
      : specimen_(specimen), body_(*geometry::make_body(specimen)) {
    for (std::size_t i = 0; i < 3; ++i) n_[i] = static_cast<int>(specimen.size[i] + 0.5);
    for (int k = 0; k <= n_[2]; ++k) {
      for (int j = 0; j <= n_[1]; ++j) {
        for (int i = 0; i <= n_[0]; ++i) {
          realization_.nodes.push_back({double(i), double(j), double(k)});
        }
      }
    }
    for (int k = 0; k < n_[2]; ++k) {
      for (int j = 0; j < n_[1]; ++j) {
        for (int i = 0; i < n_[0]; ++i) {
          const geometry::Point centre{i + 0.5, j + 0.5, k + 0.5};
          if (notch_at(centre) < 0 && (!keep || keep(centre))) add_cube({i, j, k});
        }
      }
    }
    add_notch_surfaces();
    reference_ = realization_.nodes;
  }

  const geometry::Body& body() const { return body_; }
  const geometry::Realization& realization() const { return realization_; }

  /// Moves every node; breaks are still selected by the original positions.
  void map_nodes(const std::function<geometry::Point(geometry::Point)>& map) {
    for (std::size_t i = 0; i < reference_.size(); ++i) realization_.nodes[i] = map(reference_[i]);
  }

  geometry::Point centroid(std::int64_t tetrahedron) const {
    geometry::Point c{};
    for (const auto node : realization_.tetrahedra[index(tetrahedron)]) {
      for (std::size_t i = 0; i < 3; ++i) c[i] += reference_[index(node)][i] / 4;
    }
    return c;
  }

  /// Breaks every tetrahedron whose nodes have different labels, with the cut that separates the nodes of the
  /// lowest label; a negative time means no break.
  std::vector<fracture::Break> break_between(
      const std::function<int(const geometry::Point&)>& label,
      const std::function<double(const geometry::Point&)>& time_at_centroid) const {
    std::vector<fracture::Break> breaks;
    for (std::size_t t = 0; t < realization_.tetrahedra.size(); ++t) {
      std::array<int, 4> labels{};
      for (std::size_t a = 0; a < 4; ++a) {
        labels[a] = label(reference_[index(realization_.tetrahedra[t][a])]);
      }
      const int cut = cut_between(labels);
      const double time = time_at_centroid(centroid(static_cast<std::int64_t>(t)));
      if (cut >= 0 && time >= 0) breaks.push_back({static_cast<std::int64_t>(t), 0, time, 1, 1, cut});
    }
    std::stable_sort(breaks.begin(), breaks.end(),
                     [](const auto& a, const auto& b) { return a.phase_time < b.phase_time; });
    return breaks;
  }

  /// The cut that separates the nodes with the lowest label from the others; -1 if all are equal.
  static int cut_between(const std::array<int, 4>& labels) {
    const int lowest = *std::min_element(labels.begin(), labels.end());
    std::vector<int> low;
    std::vector<int> high;
    for (int a = 0; a < 4; ++a) (labels[index(a)] == lowest ? low : high).push_back(a);
    if (low.size() == 1) return low[0];
    if (high.size() == 1) return high[0];
    if (high.empty()) return -1;
    // Cuts 4, 5, 6 pair node 0 with 1, 2, 3.
    return (low[0] == 0 ? low[1] : high[1]) + 3;
  }

private:
  using Cube = std::array<int, 3>;

  std::int32_t node(const Cube& c) const {
    return static_cast<std::int32_t>((c[2] * (n_[1] + 1) + c[1]) * (n_[0] + 1) + c[0]);
  }

  /// The notch whose slot holds this point, or -1.
  int notch_at(const geometry::Point& p) const {
    for (std::size_t i = 0; i < specimen_.notches.size(); ++i) {
      const auto& notch = specimen_.notches[i];
      const bool on_y = notch.face == plane::Face::y_min || notch.face == plane::Face::y_max;
      const bool lower = notch.face == plane::Face::y_min || notch.face == plane::Face::z_min;
      const std::size_t axis = on_y ? 1 : 2;
      const double depth = lower ? p[axis] : specimen_.size[axis] - p[axis];
      const double side = p[3 - axis] - notch.at;
      if (depth <= notch.depth && std::abs(side) <= notch.height / 2) return static_cast<int>(i);
    }
    return -1;
  }

  void add_cube(const Cube& corner) {
    std::array<std::size_t, 3> axes{0, 1, 2};
    do {
      Cube c = corner;
      geometry::Tetrahedron tetrahedron{node(c)};
      for (std::size_t step = 0; step < 3; ++step) {
        ++c[axes[step]];
        tetrahedron[step + 1] = node(c);
      }
      const bool odd = (axes[0] > axes[1]) ^ (axes[0] > axes[2]) ^ (axes[1] > axes[2]);
      if (odd) std::swap(tetrahedron[2], tetrahedron[3]);
      realization_.tetrahedra.push_back(tetrahedron);
    } while (std::next_permutation(axes.begin(), axes.end()));
  }

  /// Boundary triangles on the notches; the analysis needs no others.
  void add_notch_surfaces() {
    std::map<std::array<std::int32_t, 3>, std::pair<int, int>> faces;  // notch and number of tetrahedra
    for (const auto& t : realization_.tetrahedra) {
      for (std::size_t skip = 0; skip < 4; ++skip) {
        std::array<std::int32_t, 3> face{};
        for (std::size_t a = 0, k = 0; a < 4; ++a) {
          if (a != skip) face[k++] = t[a];
        }
        geometry::Point c{};
        for (const auto a : face) {
          for (std::size_t i = 0; i < 3; ++i) c[i] += realization_.nodes[index(a)][i] / 3;
        }
        const int notch = notch_at(c);
        if (notch < 0) continue;
        std::sort(face.begin(), face.end());
        auto& found = faces.try_emplace(face, notch, 0).first->second;
        ++found.second;
      }
    }
    for (const auto& [face, found] : faces) {
      if (found.second == 1)
        realization_.boundary.push_back({face, body_.crack_starts()[index(found.first)].faces.front()});
    }
  }

  plane::Specimen specimen_;
  geometry::Body body_;
  std::array<int, 3> n_{};
  geometry::Realization realization_;
  std::vector<geometry::Point> reference_;
};

/// A plate 4 m thick, 16 m wide and 24 m long with anti-symmetric notches, 4 m deep and one cube high, whose
/// mid-planes pass through cube centres at z = 8.5 m (from y-min) and z = 15.5 m (from y-max).
inline plane::Specimen notched_plate() {
  return {{4, 16, 24}, {{plane::Face::y_min, 8.5, 4, 1}, {plane::Face::y_max, 15.5, 4, 1}}};
}

}  // namespace crackle::test
