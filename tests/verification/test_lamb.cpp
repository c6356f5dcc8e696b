// SPDX-License-Identifier: GPL-3.0-or-later
// Lamb's problem: a point force on the free surface of a half-space, against the closed form of Pekeris
// (1955) and Mooney (1974) for Poisson's ratio 1/4.
#include "common/index.h"

#include "support/elastic_motion.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <utility>
#include <vector>

namespace crackle::dynamics {
namespace CRACKLE_TEST_FILE {

using input::BoundaryKind;
using plane::Face;

const double root3 = std::sqrt(3.0);

/// Integral over tau from 0 of the surface's vertical displacement due to a vertical unit step force at
/// distance r, times pi mu r; tau is the time in units of the shear wave's travel time, c_S t / r.
///
/// Mooney's displacement, times 32: 6 - sqrt(3) / sqrt(tau^2 - 1/4) - a / sqrt(g^2 - tau^2)
/// + b / sqrt(tau^2 - k^2) from the P to the S wave, 12 - 2 a / sqrt(g^2 - tau^2) to the Rayleigh wave, 12
/// after it.
double pekeris_integral(double tau) {
  const double p = 1 / root3, g = std::sqrt(3 + root3) / 2, k = std::sqrt(3 - root3) / 2;
  const double a = std::sqrt(3 * root3 + 5), b = std::sqrt(3 * root3 - 5);
  double sum = 0;
  if (tau > p) {
    const double end = std::min(tau, 1.0);
    sum += 6 * (end - p) - root3 * (std::acosh(2 * end) - std::acosh(2 * p)) -
           a * (std::asin(end / g) - std::asin(p / g)) + b * (std::acosh(end / k) - std::acosh(p / k));
  }
  if (tau > 1) {
    const double end = std::min(tau, g);
    sum += 12 * (end - 1) - 2 * a * (std::asin(end / g) - std::asin(1 / g));
  }
  if (tau > g) sum += 12 * (tau - g);
  return sum / 32;
}

/// A quarter of a block of stone with the force at its corner (0, 0, top); two walls are symmetry planes, the
/// others reflect after the compared times.
class Block {
public:
  explicit Block(double spacing)
      : motion_(test::irregular_box(size, spacing), parameters(), input::Integrator::verlet) {}

  /// @return largest difference from the closed form over surface nodes and times, relative to its largest
  ///   value
  double error() {
    motion_.start(duration);
    constexpr int n_moments = 60;
    const double interval = duration / n_moments;
    const auto n_steps = static_cast<std::int64_t>(std::ceil(interval / (0.9 * motion_.stable_step())));
    std::vector<std::size_t> watched;
    for (std::size_t n = 0; n < motion_.n_nodes(); ++n) {
      const auto& x = motion_.subdomain().nodes[n];
      const double r = std::hypot(x[0], x[1]);
      if (x[2] == size[2] && r > nearest && r < farthest) watched.push_back(n);
    }
    double largest = 0, square = 0, whole = 0;
    n_watched_ = watched.size();
    worst_ = 0;
    for (int moment = 1; moment <= n_moments; ++moment) {
      motion_.advance(n_steps, interval / static_cast<double>(n_steps));
      for (const auto n : watched) {
        const double exact = closed_form(n, moment * interval);
        const double difference = motion_.displacement(n, 2) - exact;
        largest = std::max(largest, std::abs(exact));
        worst_ = std::max(worst_, std::abs(difference));
        square += difference * difference;
        whole += exact * exact;
      }
    }
    worst_ /= largest;
    return std::sqrt(square / whole);
  }
  double worst() const { return worst_; }
  std::size_t n_watched() const { return n_watched_; }

  static constexpr geometry::Point size{0.0148, 0.0148, 0.011};
  static constexpr double nearest = 0.005, farthest = 0.0065;
  /// The P wave returns from the far walls after (2 * 14.8 - 6.5 - 1) mm / c_P = 3.8 us, as from the bottom.
  static constexpr double duration = 3.8e-6;
  static constexpr double rise = 1.5e-6;

private:
  static input::Parameters parameters() {
    input::Parameters parameters;
    parameters.materials[0] = {70e9, 0.25, 2500};
    parameters.specimen.size = size;
    for (const auto& [face, axis] : {std::pair{Face::x_min, 0}, {Face::y_min, 1}}) {
      std::array<bool, 3> held{};
      held[index(axis)] = true;
      parameters.boundaries.push_back(test::boundary(face, BoundaryKind::fix, held));
    }
    auto force = test::boundary(Face::z_max, BoundaryKind::force, {}, {0, 0, total_force / 4});
    force.region[0] = force.region[1] = {0, 0.001};
    for (int i = 0; i <= n_pieces; ++i) force.history.push_back({rise * i / n_pieces, history(i)});
    parameters.boundaries.push_back(force);
    return parameters;
  }
  /// A smooth growth to 1.
  static double history(int i) { return std::pow(std::sin(std::acos(-1.0) / 2 * i / n_pieces), 2); }

  /// Sum over the loaded nodes and their mirror images, each with its nodal force in the mesh.
  double closed_form(std::size_t node, double time) const {
    const mechanics::IsotropicElasticity elasticity({70e9, 0.25, 2500});
    const double c = std::sqrt(elasticity.mu / 2500);
    const auto& x = motion_.subdomain().nodes[node];
    const auto& pattern = motion_.loads().forces.back();
    double sum = 0;
    for (std::size_t i = 0; i < pattern.nodes.size(); ++i) {
      const auto& at = motion_.subdomain().nodes[index(pattern.nodes[i])];
      for (const double sx : {-1.0, 1.0}) {
        for (const double sy : {-1.0, 1.0}) {
          const double r = std::hypot(x[0] - sx * at[0], x[1] - sy * at[1]);
          // The force is a sum of ramps, which start where its slope changes.
          double of_ramps = 0, slope = 0;
          for (int k = 0; k <= n_pieces; ++k) {
            const double next = k == n_pieces ? 0 : (history(k + 1) - history(k)) * n_pieces / rise;
            const double since = time - rise * k / n_pieces;
            if (since > 0) of_ramps += (next - slope) * (r / c) * pekeris_integral(c * since / r);
            slope = next;
          }
          sum += pattern.weight[i] * of_ramps / (std::acos(-1.0) * elasticity.mu * r);
        }
      }
    }
    return total_force / 4 * sum;
  }

  static constexpr double total_force = 400;
  static constexpr int n_pieces = 20;
  test::ElasticMotion motion_;
  double worst_ = 0;
  std::size_t n_watched_ = 0;
};

TEST(LambsProblem, SurfaceMovesAsInTheClosedForm) {
  // In the limit Boussinesq's displacement (1 - nu) / (2 pi mu r).
  EXPECT_NEAR(pekeris_integral(9) - pekeris_integral(8), 3.0 / 8, 1e-12);
  std::vector<double> errors;
  for (const double spacing : {0.5e-3, 0.35e-3}) {
    Block block(spacing);
    errors.push_back(block.error());
    std::printf(
        "Lamb's problem, spacing %.2f mm: vertical displacement of %zu surface nodes at 5 to 6.5 mm, root "
        "mean "
        "square difference to the closed form %.2f %%, largest %.2f %% (reference 0)\n",
        1e3 * spacing, block.n_watched(), 100 * errors.back(), 100 * block.worst());
  }
  EXPECT_LT(errors.back(), 0.015);
  EXPECT_LT(errors[1], 0.6 * errors[0]) << "order 1.9 is left near the end";
}

}  // namespace CRACKLE_TEST_FILE
}  // namespace crackle::dynamics
