// SPDX-License-Identifier: GPL-3.0-or-later
// Random bodies, spacings and perturbations: each is refused when the body is made, with a reason, or every
// one of its realizations conforms.
#include "crackle/geometry/mother_points.h"
#include "crackle/geometry/realization.h"
#include "crackle/parallel/random.h"
#include "support/geometry_bodies.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <optional>
#include <stdexcept>
#include <string>

namespace crackle::geometry {
namespace {

struct Problem {
  input::Specimen specimen;
  input::Mesh mesh;
};

Problem random_problem(std::uint64_t number) {
  parallel::RandomStream stream(1, number, "random bodies");
  const auto log_uniform = [&](double lower, double upper) {
    return lower * std::exp(stream.uniform(0, std::log(upper / lower)));
  };
  Problem problem;
  problem.specimen.size = {log_uniform(1e-3, 8e-3), log_uniform(4e-3, 30e-3), log_uniform(4e-3, 50e-3)};
  const auto n_notches = static_cast<int>(stream.uniform(0, 5));
  for (int i = 0; i < n_notches; ++i) {
    const auto face = static_cast<input::Face>(2 + static_cast<int>(stream.uniform(0, 4)));
    const bool across_y = face == input::Face::y_min || face == input::Face::y_max;
    const double depth_limit = problem.specimen.size[across_y ? 1 : 2];
    const double at_limit = problem.specimen.size[across_y ? 2 : 1];
    problem.specimen.notches.push_back({.face = face,
                                        .at = at_limit * stream.uniform(0.05, 0.95),
                                        .depth = depth_limit * stream.uniform(0.02, 0.9),
                                        .height = log_uniform(1e-4, 0.3 * at_limit)});
  }
  problem.mesh.spacing = log_uniform(0.5e-3, 4e-3);
  problem.mesh.notch_spacing = problem.mesh.spacing * log_uniform(0.15, 1);
  problem.mesh.growth = log_uniform(0.01, 1);
  problem.mesh.perturbation = stream.uniform(0, 0.35);
  problem.mesh.min_quality = 0.2;
  return problem;
}

TEST(Family, EveryBodyConformsOrIsRefused) {
  constexpr std::uint64_t n_problems = 60;
  constexpr double max_points = 4000;  // keeps the test short
  int n_refused = 0;
  int n_conforming = 0;
  int n_notched = 0;
  int most_rounds = 0;
  for (std::uint64_t number = 0; number < n_problems; ++number) {
    SCOPED_TRACE("problem " + std::to_string(number));
    const Problem problem = random_problem(number);
    std::optional<Body> body;
    try {
      body.emplace(problem.specimen);
    } catch (const std::runtime_error& refusal) {
      ++n_refused;
      EXPECT_NE(std::string(refusal.what()).find("notch"), std::string::npos);
      continue;
    }
    if (estimate_n_points(*body, problem.mesh) > max_points) continue;
    const MotherPoints base = make_mother_points(*body, problem.mesh, number);
    for (std::uint64_t sample = 0; sample < 2; ++sample) {
      const Realization made = make_realization(*body, base, problem.mesh, number, sample);
      EXPECT_GE(verify(made, *body, problem.mesh.min_quality), 0.2 * (1 - 1e-12));
      most_rounds = std::max(most_rounds, made.report.rounds);
    }
    ++n_conforming;
    n_notched += body->n_notches() > 0;
  }
  std::printf("%d bodies conform, %d of them notched; %d refused; at most %d rounds\n", n_conforming,
              n_notched, n_refused, most_rounds);
  EXPECT_GE(n_conforming, 25);
  EXPECT_GE(n_notched, 15);
  EXPECT_GE(n_refused, 3);
}

}  // namespace
}  // namespace crackle::geometry
