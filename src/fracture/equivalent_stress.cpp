// SPDX-License-Identifier: GPL-3.0-or-later
#include "fracture/equivalent_stress.h"

#include <Eigen/Eigenvalues>

namespace crackle::fracture {

LargestPrincipalStress::LargestPrincipalStress() : EquivalentStress({1, 4.0 / 3.0}) {}

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
