// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "common/index.h"
#include "common/random.h"
#include "fracture/fracture_law.h"
#include "fracture/tuler_butcher.h"
#include "geometry/partition.h"
#include "geometry/realization.h"
#include "geometry/subdomain.h"
#include "input/parameters.h"

#include <algorithm>
#include <array>
#include <functional>
#include <map>
#include <vector>

/// Small meshes with known exact solutions: a box of cells, each cut into six tetrahedra.
namespace crackle::test {

struct BoxMesh {
  geometry::Point size{1, 1, 1};
  std::array<int, 3> cells{1, 1, 1};
  double disturbance = 0;  ///< of the nodes, in cell sizes; nodes on a face stay in the face
  std::function<bool(const geometry::Point& centre)> removed = [](const geometry::Point&) { return false; };
};

inline geometry::Realization make_box(const BoxMesh& box) {
  geometry::Realization mesh;
  const auto [nx, ny, nz] = box.cells;
  const auto number = [&](int i, int j, int k) { return (k * (ny + 1) + j) * (nx + 1) + i; };
  std::vector<geometry::Point> grid;
  for (int k = 0; k <= nz; ++k) {
    for (int j = 0; j <= ny; ++j) {
      for (int i = 0; i <= nx; ++i) {
        const std::array<int, 3> index{i, j, k};
        geometry::Point p{};
        RandomStream stream(1, 0, "box");
        stream = stream.substream(static_cast<std::uint64_t>(number(i, j, k)));
        for (std::size_t a = 0; a < 3; ++a) {
          const double h = box.size[a] / box.cells[a];
          const bool inside = index[a] > 0 && index[a] < box.cells[a];
          p[a] = index[a] == box.cells[a] ? box.size[a] : index[a] * h;
          const double shift = stream.uniform(-1, 1) * box.disturbance * h;
          if (inside) p[a] += shift;
        }
        grid.push_back(p);
      }
    }
  }
  // Kuhn's subdivision: one tetrahedron for each order in which a path along the axes crosses the cell.
  const std::array<std::array<int, 3>, 6> orders{
      {{0, 1, 2}, {0, 2, 1}, {1, 0, 2}, {1, 2, 0}, {2, 0, 1}, {2, 1, 0}}};
  for (int k = 0; k < nz; ++k) {
    for (int j = 0; j < ny; ++j) {
      for (int i = 0; i < nx; ++i) {
        const geometry::Point centre{(i + 0.5) * box.size[0] / nx, (j + 0.5) * box.size[1] / ny,
                                     (k + 0.5) * box.size[2] / nz};
        if (box.removed(centre)) continue;
        for (std::size_t o = 0; o < orders.size(); ++o) {
          std::array<int, 3> at{i, j, k};
          geometry::Tetrahedron t{number(i, j, k), 0, 0, 0};
          for (std::size_t s = 0; s < 3; ++s) {
            ++at[index(orders[o][s])];
            t[s + 1] = number(at[0], at[1], at[2]);
          }
          const bool odd = o == 1 || o == 2 || o == 5;
          if (odd) std::swap(t[2], t[3]);
          mesh.tetrahedra.push_back(t);
        }
      }
    }
  }
  // Keep only nodes used by a tetrahedron.
  std::vector<std::int32_t> renumbered(grid.size(), -1);
  for (const auto& t : mesh.tetrahedra) {
    for (const auto node : t) renumbered[index(node)] = 0;
  }
  for (std::size_t n = 0; n < grid.size(); ++n) {
    if (renumbered[n] < 0) continue;
    renumbered[n] = static_cast<std::int32_t>(mesh.nodes.size());
    mesh.nodes.push_back(grid[n]);
  }
  for (auto& t : mesh.tetrahedra) {
    for (auto& node : t) node = renumbered[index(node)];
  }
  std::map<std::array<std::int32_t, 3>, std::pair<int, geometry::Triangle>> faces;
  constexpr std::array<std::array<std::size_t, 3>, 4> outward{{{1, 2, 3}, {0, 3, 2}, {0, 1, 3}, {0, 2, 1}}};
  for (const auto& t : mesh.tetrahedra) {
    for (const auto& corners : outward) {
      const geometry::Triangle triangle{t[corners[0]], t[corners[1]], t[corners[2]]};
      auto key = triangle;
      std::ranges::sort(key);
      auto& entry = faces[key];
      ++entry.first;
      entry.second = triangle;
    }
  }
  for (const auto& [key, entry] : faces) {
    if (entry.first != 1) continue;
    constexpr std::array<geometry::FaceId, 6> number{0, 1, 5, 3, 2, 4};  // of the faces in a box's body
    geometry::FaceId surface = 6;                                        // wall of a cut-out
    for (std::size_t axis = 0; axis < 3; ++axis) {
      for (const double side : {0.0, 1.0}) {
        const bool on_side = std::ranges::all_of(
            key, [&](std::int32_t node) { return mesh.nodes[index(node)][axis] == side * box.size[axis]; });
        if (on_side) surface = number[2 * axis + (side > 0 ? 1 : 0)];
      }
    }
    mesh.boundary.push_back({entry.second, surface});
  }
  return mesh;
}

inline geometry::Subdomain whole(const geometry::Realization& mesh) {
  return geometry::split(mesh, geometry::partition(mesh, 1)).front();
}

/// The paper's epoxy in SI.
inline input::Material epoxy() {
  return {.youngs_modulus = 3300e6, .poisson_ratio = 0.38, .density = 1180};
}

inline input::Boundary boundary(plane::Face face, input::BoundaryKind kind,
                                std::array<bool, 3> components = {}, Vector value = {}, Vector rate = {}) {
  input::Boundary condition;
  condition.on = name_of(face);
  condition.kind = kind;
  condition.components = components;
  condition.value = value;
  condition.rate = rate;
  return condition;
}

/// A body of epoxy, or of another material, that breaks at 35 MPa.
inline input::Parameters brittle(const Vector& size, const input::Material& material = epoxy()) {
  input::Parameters parameters;
  parameters.specimen.size = size;
  parameters.materials[0] = material;
  parameters.fracture = {.strength = 35e6, .exponent = 2, .impulse = 1e4};
  // Weak tetrahedra break one by one, which makes many phases, breaks and pieces.
  parameters.fracture.nucleation = input::Nucleation::own_stress;
  parameters.time.duration = 4e-5;
  return parameters;
}

/// A bar torn apart from rest, with time-dependent loads and a driven end. It ends before fragments exceed
/// the range of mixed precision.
inline input::Parameters torn_bar(double time_step) {
  using input::BoundaryKind;
  using plane::Face;
  auto parameters = brittle({0.002, 0.004, 0.012});
  parameters.fracture.impulse = 1e5;
  parameters.time.start = input::Start::rest;
  parameters.time.duration = 1.2e-5;
  parameters.time.step = time_step;
  parameters.boundaries = {boundary(Face::z_min, BoundaryKind::velocity, {true, true, true}, {0, 0, -1}),
                           boundary(Face::z_max, BoundaryKind::traction, {}, {0, 3e6, 22e6}, {0, 0, 1e11})};
  parameters.output.frames = 4;
  return parameters;
}

/// The bar loaded slowly, with so little patience that dynamic phases arrest and loading continues.
inline input::Parameters pulled_bar(input::Parameters parameters) {
  using input::BoundaryKind;
  using plane::Face;
  parameters.time.start = input::Start::quasi_static;
  parameters.time.arrest = 2.5e-6;
  parameters.boundaries = {boundary(Face::z_min, BoundaryKind::fix, {true, true, true}),
                           boundary(Face::z_max, BoundaryKind::force, {}, {}, {0, 0, 10})};
  return parameters;
}

/// Pulled along z by a force that grows by 1 N/s, with symmetry on three faces: the stress is uniform, as in
/// a bar.
inline std::vector<input::Boundary> uniform_pull() {
  using input::BoundaryKind;
  using plane::Face;
  return {boundary(Face::x_min, BoundaryKind::fix, {true, false, false}),
          boundary(Face::y_min, BoundaryKind::fix, {false, true, false}),
          boundary(Face::z_min, BoundaryKind::fix, {false, false, true}),
          boundary(Face::z_max, BoundaryKind::force, {}, {}, {0, 0, 1})};
}

/// Tuler-Butcher with uniform strength from the input.
inline fracture::FractureLaw tuler_butcher(const input::Fracture& parameters,
                                           const geometry::Subdomain& subdomain, double time_step = 5e-9) {
  return fracture::FractureLaw(std::make_unique<fracture::TulerButcher>(
      parameters, parameters.impulse, std::vector<double>(subdomain.tetrahedra.size(), parameters.strength),
      time_step));
}

/// A law by which nothing breaks.
inline fracture::FractureLaw unbreakable(const geometry::Subdomain& subdomain, double strength = 1e15) {
  return tuler_butcher({.strength = strength, .exponent = 2, .impulse = 1e4}, subdomain);
}

}  // namespace crackle::test
