// SPDX-License-Identifier: GPL-3.0-or-later
// Random bodies, spacings and perturbations: each is refused before any realization is made, for a reason
// that is found true by other means, or every one of its realizations conforms.
//
// CRACKLE_FAMILY=300 in the environment gives the number of bodies, CRACKLE_FAMILY_POINTS=200000 the most
// points that one may have.
#include "common/random.h"
#include "common/stopwatch.h"
#include "geometry/body.h"
#include "geometry/mother_points.h"
#include "geometry/realization.h"
#include "input/parameters.h"
#include "support/effort.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <cstdio>
#include <map>
#include <optional>
#include <stdexcept>
#include <string>

// A family of random bodies with meshes, and the reasons to refuse one, determined independently of the
// geometry.
namespace crackle::testing {

struct MeshProblem {
  plane::Specimen specimen;
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
    const auto face = static_cast<plane::Face>(2 + (all_faces ? i : number(4)));
    const bool across_y = face == plane::Face::y_min || face == plane::Face::y_max;
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
inline std::array<std::array<double, 2>, 2> slot_in_plane(const plane::Notch& notch, const Vector& size) {
  const std::array<double, 2> along{notch.at - notch.height / 2, notch.at + notch.height / 2};
  switch (notch.face) {
    case plane::Face::y_min:
      return {{{0, notch.depth}, along}};
    case plane::Face::y_max:
      return {{{size[1] - notch.depth, size[1]}, along}};
    case plane::Face::z_min:
      return {{along, {0, notch.depth}}};
    default:
      return {{along, {size[2] - notch.depth, size[2]}}};
  }
}

/// Why no such body exists; empty if it does.
inline std::string impossible(const plane::Specimen& specimen) {
  const auto& notches = specimen.notches;
  for (std::size_t i = 0; i < notches.size(); ++i) {
    const bool across_y = notches[i].face == plane::Face::y_min || notches[i].face == plane::Face::y_max;
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
  for (const plane::Notch& notch : specimen.notches) {
    const double near = std::min({notch.height, notch.depth, far});
    const double layers = (1 / (near * near) - 1 / (far * far)) / (2 * std::max(mesh.growth, 0.2));
    n = std::max(n, 2 * size[0] * notch.depth * (1 / (near * near) + layers));
  }
  return n;
}

}  // namespace crackle::testing

namespace crackle::geometry {
namespace CRACKLE_TEST_FILE {

using testing::MeshProblem;

/// Result for one body.
struct Verdict {
  std::string refusal;  ///< the message; empty if the body was meshed
  int n_notches = 0;
  std::size_t n_points = 0;
  double worst = 1;  ///< lowest quality
  int rounds = 0;
};

/// A body of the family with at most `max_points` points; absurd ones may have any number.
MeshProblem draw(std::uint64_t number, double max_points) {
  const RandomStream stream(1, number, "random bodies");
  const bool absurd = number % 15 == 0;
  for (std::uint64_t attempt = 0;; ++attempt) {
    MeshProblem problem = testing::random_problem(stream.substream(attempt), absurd);
    if (!testing::impossible(problem.specimen).empty()) {
      if (number % 4 == 1) return problem;
      continue;
    }
    try {
      const double n_points = estimate_n_points(*make_body(problem.specimen), problem.mesh);
      if (absurd ? n_points > input::max_mother_points : n_points <= max_points) return problem;
    } catch (const std::runtime_error&) {
      return problem;  // make_mother_points must refuse it for the same reason
    }
  }
}

/// @throws std::runtime_error when a realization cannot be made
Verdict mesh(const MeshProblem& problem, std::uint64_t seed) {
  constexpr std::uint64_t n_samples = 2;
  Verdict verdict;
  std::optional<Body> body;
  MotherPoints base;
  try {
    body = *make_body(problem.specimen);
    base = make_mother_points(*body, problem.mesh, seed);
  } catch (const std::runtime_error& refusal) {
    verdict.refusal = refusal.what();
    return verdict;
  }
  verdict.n_notches = static_cast<int>(body->crack_starts().size());
  verdict.n_points = base.size();
  for (std::uint64_t sample = 0; sample < n_samples; ++sample) {
    const Realization made = make_realization(*body, base, problem.mesh, seed, sample);
    verdict.worst = std::min(verdict.worst, verify(made, *body, problem.mesh.min_quality));
    verdict.rounds = std::max(verdict.rounds, made.report.rounds);
  }
  return verdict;
}

/// The true reason for a refusal, identified by its message; empty if the message is wrong.
std::string true_reason(const MeshProblem& problem, const std::string& refusal) {
  const auto says = [&](const char* words) { return refusal.find(words) != std::string::npos; };
  const std::string impossible = testing::impossible(problem.specimen);
  if (says("cuts the body in two") || says("overlap or touch") || says("does not lie inside the face"))
    return impossible;
  if (!impossible.empty()) return "";
  if (says("more than 2e+07 mother points") &&
      testing::rough_number_of_points(problem) > input::max_mother_points / 3)
    return "too many points";
  if (says("times as long as the finest spacing") &&
      testing::rough_number_of_points(problem) > input::max_mother_points / 3)
    return "an edge of too many spacings";
  return "";
}

TEST(Family, EveryBodyConformsOrIsRefusedForATrueReason) {
  const auto n_bodies =
      static_cast<std::uint64_t>(test::from_environment("CRACKLE_FAMILY", test::repetitions(5, 60)));
  const double max_points = test::from_environment("CRACKLE_FAMILY_POINTS", 6000);
  std::map<std::string, int> refused;
  std::map<int, int> conforming;  // by the number of notches
  int n_failed = 0;
  Verdict extreme;
  const Stopwatch clock;
  for (std::uint64_t number = 0; number < n_bodies; ++number) {
    SCOPED_TRACE("body " + std::to_string(number));
    const MeshProblem problem = draw(number, max_points);
    try {
      const Verdict verdict = mesh(problem, number);
      if (verdict.refusal.empty()) {
        EXPECT_EQ(testing::impossible(problem.specimen), "");
        EXPECT_GE(verdict.worst, problem.mesh.min_quality * (1 - 1e-12));
        ++conforming[verdict.n_notches];
        extreme.worst = std::min(extreme.worst, verdict.worst);
        extreme.rounds = std::max(extreme.rounds, verdict.rounds);
        extreme.n_points = std::max(extreme.n_points, verdict.n_points);
        continue;
      }
      const std::string reason = true_reason(problem, verdict.refusal);
      EXPECT_NE(reason, "") << verdict.refusal;
      ++refused[reason.empty() ? "for a reason that is not true" : reason];
    } catch (const std::runtime_error& failure) {
      ++n_failed;
      ADD_FAILURE() << failure.what();
    }
  }
  int n_conforming = 0;
  int n_refused = 0;
  for (const auto& [n_notches, count] : conforming) n_conforming += count;
  for (const auto& [reason, count] : refused) n_refused += count;
  std::printf("%lu bodies in %.0f s: %d conform, %d are refused, %d fail\n",
              static_cast<unsigned long>(n_bodies), clock.seconds(), n_conforming, n_refused, n_failed);
  for (const auto& [n_notches, count] : conforming)
    std::printf("  conform, %d notches: %d\n", n_notches, count);
  for (const auto& [reason, count] : refused) std::printf("  refused, %s: %d\n", reason.c_str(), count);
  std::printf("  at most %zu points and %d rounds, worst quality %.4f\n", extreme.n_points, extreme.rounds,
              extreme.worst);
  EXPECT_GE(n_conforming, static_cast<int>(n_bodies / 2));
  EXPECT_GE(n_refused, static_cast<int>(n_bodies / 20));
}

}  // namespace CRACKLE_TEST_FILE
}  // namespace crackle::geometry
