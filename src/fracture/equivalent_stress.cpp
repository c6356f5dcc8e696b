// SPDX-License-Identifier: GPL-3.0-or-later
#include "fracture/equivalent_stress.h"

#include <Eigen/Eigenvalues>

#include <algorithm>
#include <cmath>

namespace crackle::fracture {

LargestPrincipalStress::LargestPrincipalStress() : EquivalentStress({1, 4.0 / 3.0}) {}

/// By Sylvester's criterion: whether the level's tensor less the stress is positive definite.
int LargestPrincipalStress::side(const mechanics::Symmetric& s, double level) const {
  if (bound(s) < level - rounding(s)) return -1;
  double scale = std::abs(level);
  for (const double component : s) scale += std::abs(component);
  const double a = level - s[0], b = level - s[1], c = level - s[2];
  const double minor = a * b - s[5] * s[5];
  const double determinant = minor * c - a * s[3] * s[3] - b * s[4] * s[4] - 2 * s[3] * s[4] * s[5];
  // Far above the rounding errors, also of the value.
  constexpr double least = 1e-12;
  const auto sign = [](double value, double small) { return value > small ? 1 : value < -small ? -1 : 0; };
  const int lowest = std::min({sign(a, least * scale), sign(minor, least * scale * scale),
                               sign(determinant, least * scale * scale * scale)});
  return -lowest;
}

std::unique_ptr<const EquivalentStress> make_equivalent_stress(const input::Fracture&) {
  return std::make_unique<LargestPrincipalStress>();
}

double largest_principal(const mechanics::Symmetric& tensor) {
  Eigen::Matrix3d matrix;
  matrix << tensor[0], tensor[5], tensor[4], tensor[5], tensor[1], tensor[3], tensor[4], tensor[3], tensor[2];
  // The iterative solver, not computeDirect, which needs trigonometric functions and loses digits where two
  // principal values coincide, as they do at a crack front.
  const Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> solver(matrix, Eigen::EigenvaluesOnly);
  return solver.eigenvalues()[2];
}

}  // namespace crackle::fracture
