// SPDX-License-Identifier: GPL-3.0-or-later
#include "mechanics/rigid_motion.h"

#include "common/index.h"
#include "parallel/exact_sum.h"

#include <Eigen/Eigenvalues>

#include <cmath>

namespace crackle::mechanics {

namespace {

using Motions = Eigen::Matrix<double, 6, 1>;  // three translations, three rotations

/// Displacement component of a point in each rigid motion.
Motions motions_at(const geometry::Point& p, int component) {
  Motions motions = Motions::Zero();
  motions[component] = 1;
  for (int axis = 0; axis < 3; ++axis) {
    Vector turning{};
    turning[index(axis)] = 1;
    motions[3 + axis] = cross(turning, p)[index(component)];
  }
  return motions;
}

template <class Term>
double sum_over_constrained(const parallel::Communicator& group, const Conditions& loads, Term&& term) {
  std::vector<double> terms;
  for (const auto& motion : loads.motions)
    for (const auto node : motion.nodes) terms.push_back(term(node, motion.component));
  for (const Support& support : loads.supports)
    for (int c = 0; c < 3; ++c)
      if ((support.components >> c & 1) != 0) terms.push_back(term(support.node, c));
  return parallel::exact_sum(group, terms);
}

}  // namespace

std::vector<std::string> free_rigid_motions(const parallel::Communicator& group,
                                            const geometry::Subdomain& subdomain, const Conditions& loads) {
  const auto point = [&](std::int32_t node) { return subdomain.nodes[index(node)]; };
  const double n = sum_over_constrained(group, loads, [](std::int32_t, int) { return 1.0; });
  Vector centre{};
  for (std::size_t i = 0; i < 3 && n > 0; ++i)
    centre[i] =
        sum_over_constrained(group, loads, [&](std::int32_t node, int) { return point(node)[i]; }) / n;
  double radius = std::sqrt(sum_over_constrained(group, loads, [&](std::int32_t node, int) {
    const Vector from = point(node) - centre;
    return dot(from, from);
  }));
  if (n > 0) radius /= std::sqrt(n);
  if (radius == 0) radius = 1;

  Eigen::Matrix<double, 6, 6> gram;
  for (int a = 0; a < 6; ++a) {
    for (int b = 0; b <= a; ++b) {
      gram(a, b) = gram(b, a) = sum_over_constrained(group, loads, [&](std::int32_t node, int component) {
        const Motions motions = motions_at((point(node) - centre) / radius, component);
        return motions[a] * motions[b];
      });
    }
  }
  const Eigen::SelfAdjointEigenSolver<Eigen::Matrix<double, 6, 6>> solver(gram);
  // A constrained strip of a thousandth of the body's size gives 1e-6; rounding gives 1e-16.
  constexpr double negligible = 1e-12;
  Motions freedom = Motions::Zero();  // share of each motion that is free
  for (int k = 0; k < 6; ++k)
    if (solver.eigenvalues()[k] <= negligible * n) freedom += solver.eigenvectors().col(k).cwiseAbs2();
  std::vector<std::string> found;
  for (int k = 3; k < 6; ++k)
    if (freedom[k] > negligible) found.push_back(std::string("turn about ") + "xyz"[k - 3]);
  if (!found.empty()) return found;  // the centre of the constrained nodes may move as a result
  for (int k = 0; k < 3; ++k)
    if (freedom[k] > negligible) found.push_back(std::string("translate along ") + "xyz"[k]);
  return found;
}

}  // namespace crackle::mechanics
