// SPDX-License-Identifier: GPL-3.0-or-later
// A family of random bodies with meshes, and the reasons to refuse one, determined independently of the
// geometry.
#pragma once

#include "crackle/common/random.h"
#include "crackle/input/parameters.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <string>

namespace crackle::testing {

struct MeshProblem {
  input::Specimen specimen;
  input::Mesh mesh;
};

/// Bodies from 0.1 mm to 8 mm thick with up to five notches in all four faces, a few of them invalid; coarse
/// and fine spacings, perturbations from 0 to 0.35.
/// @param absurd with a notch so thin, or a spacing so small, that meshing is practically impossible
inline MeshProblem random_problem(RandomStream stream, bool absurd) {
  const auto log_uniform = [&](double lower, double upper) {
    return lower * std::exp(stream.uniform(0, std::log(upper / lower)));
  };
  const auto number = [&](int n) { return static_cast<int>(stream.uniform(0, n)); };
  MeshProblem problem;
  auto& [specimen, mesh] = problem;
  specimen.size = {log_uniform(1e-4, 8e-3), log_uniform(2e-3, 60e-3), log_uniform(2e-3, 140e-3)};
  const bool all_faces = number(8) == 0;
  const int n_notches = all_faces ? 4 : number(6);
  for (int i = 0; i < n_notches; ++i) {
    const auto face = static_cast<input::Face>(2 + (all_faces ? i : number(4)));
    const bool across_y = face == input::Face::y_min || face == input::Face::y_max;
    const double depth_limit = specimen.size[across_y ? 1 : 2];
    const double at_limit = specimen.size[across_y ? 2 : 1];
    const bool wrong = number(40) == 0;
    specimen.notches.push_back(
        {.face = face,
         .at = at_limit * stream.uniform(0.05, 0.95),
         .depth = depth_limit * (wrong ? stream.uniform(1, 1.2) : log_uniform(0.02, 0.9)),
         .height = log_uniform(1e-4, std::max(2e-4, 0.3 * at_limit))});
  }
  mesh.spacing =
      std::min(log_uniform(0.3e-3, 5e-3), *std::min_element(specimen.size.begin(), specimen.size.end()));
  mesh.notch_spacing = mesh.spacing * log_uniform(0.15, 1);
  mesh.growth = log_uniform(0.01, 1);
  mesh.perturbation = stream.uniform(0, 0.35);
  mesh.min_quality = stream.uniform(0.05, 0.25);
  if (!absurd) return problem;
  if (specimen.notches.empty()) {
    mesh.spacing = mesh.notch_spacing = log_uniform(1e-9, 2e-6);
  } else {
    specimen.notches[0].height = log_uniform(1e-9, 5e-7);
  }
  return problem;
}

/// A slot in the plane of y and z, closed.
inline std::array<std::array<double, 2>, 2> slot_in_plane(const input::Notch& notch, const Vector& size) {
  const std::array<double, 2> along{notch.at - notch.height / 2, notch.at + notch.height / 2};
  switch (notch.face) {
    case input::Face::y_min:
      return {{{0, notch.depth}, along}};
    case input::Face::y_max:
      return {{{size[1] - notch.depth, size[1]}, along}};
    case input::Face::z_min:
      return {{along, {0, notch.depth}}};
    default:
      return {{along, {size[2] - notch.depth, size[2]}}};
  }
}

/// Why no such body exists; empty if it does.
inline std::string impossible(const input::Specimen& specimen) {
  const auto& notches = specimen.notches;
  for (std::size_t i = 0; i < notches.size(); ++i) {
    const bool across_y = notches[i].face == input::Face::y_min || notches[i].face == input::Face::y_max;
    if (notches[i].depth >= specimen.size[across_y ? 1 : 2]) return "a notch cuts the body in two";
    const double half = notches[i].height / 2;
    if (notches[i].at - half <= 0 || notches[i].at + half >= specimen.size[across_y ? 2 : 1])
      return "a slot leaves its face";
    const auto slot = slot_in_plane(notches[i], specimen.size);
    for (std::size_t j = 0; j < i; ++j) {
      const auto other = slot_in_plane(notches[j], specimen.size);
      bool meet = true;
      for (std::size_t axis = 0; axis < 2; ++axis)
        meet = meet && slot[axis][0] <= other[axis][1] && other[axis][0] <= slot[axis][1];
      if (meet) return "two notches overlap";
    }
  }
  return "";
}

/// The number of points required by a body, to a factor of three: in the whole at the coarsest spacing, or
/// along the two walls of one of its slots, with the layers that grow away from them.
inline double rough_number_of_points(const MeshProblem& problem) {
  const auto& [specimen, mesh] = problem;
  const Vector& size = specimen.size;
  const double far = std::min(mesh.spacing, std::min({size[0], size[1], size[2]}));
  double n = size[0] * size[1] * size[2] / (far * far * far);
  for (const input::Notch& notch : specimen.notches) {
    const double near = std::min({notch.height, notch.depth, far});
    const double layers = (1 / (near * near) - 1 / (far * far)) / (2 * std::max(mesh.growth, 0.2));
    n = std::max(n, 2 * size[0] * notch.depth * (1 / (near * near) + layers));
  }
  return n;
}

}  // namespace crackle::testing
