// SPDX-License-Identifier: GPL-3.0-or-later
// Difficult quasi-static loading: hundreds of stable breaks, loose tetrahedra, parts that hang by an edge.
#include "common/index.h"
#include "dynamics/quasi_static.h"
#include "dynamics/sample_run.h"
#include "dynamics/separation.h"
#include "fracture/connectivity.h"

#include "support/box_mesh.h"
#include "support/effort.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <set>

namespace crackle::dynamics {
namespace CRACKLE_TEST_FILE {

using input::BoundaryKind;
using plane::Face;

/// Pieces of a body after these breaks, with release by elements.
std::set<std::int64_t> pieces_after(const geometry::Subdomain& subdomain,
                                    std::span<const fracture::Break> breaks) {
  const parallel::Communicator self(MPI_COMM_SELF);
  fracture::BreakableBody body(subdomain, test::epoxy());
  body.restore({{breaks.begin(), breaks.end()}, {}, {}});
  const auto labels = fracture::piece_labels(self, body);
  return {labels.begin(), labels.end()};
}

class StableBreaks : public ::testing::TestWithParam<input::Release> {};

TEST_P(StableBreaks, ByTheHundredCloseTheEnergyAccount) {
  // A wedge opens a strip; no patience for dynamics, so every break is followed by an equilibrium.
  const int n_layers = test::repetitions(3, 5);
  const double width = 0.012, length = 0.02;
  auto parameters = test::brittle({0.0004 * n_layers, width, length});
  parameters.fracture.release = GetParam();
  parameters.time.arrest = 1e-30;
  auto wedge = test::boundary(Face::y_max, BoundaryKind::displacement, {false, true, false}, {0, 1e-5, 0});
  wedge.region[2] = {0, 0.0021};
  wedge.history = {{0, 0}, {1000, 1000}};
  auto grip = test::boundary(Face::y_min, BoundaryKind::fix, {true, true, true});
  grip.region[2] = {0, 0.0021};
  parameters.boundaries = {wedge, grip};
  const auto mesh = test::make_box({.size = parameters.specimen.size,
                                    .cells = {n_layers, 11, 30},
                                    .disturbance = 0.15,
                                    .removed = [&](const geometry::Point& p) {
                                      return p[2] < 0.4 * length && std::abs(p[1] - 0.006) < 0.0005;
                                    }});
  const parallel::Communicator self(MPI_COMM_SELF);
  const auto subdomain = test::whole(mesh);
  const auto result = run_sample(self, parameters, parameters.output, subdomain);
  // Loose tetrahedra, which make the static problem singular, occur on the way.
  std::size_t n_pieces = 0;
  for (std::size_t n = 0; n < result.breaks.size(); n += 10)
    n_pieces = std::max(n_pieces, pieces_after(subdomain, std::span(result.breaks).first(n)).size());
  std::printf(
      "%s: %zu breaks in %lld dynamic phases, up to %zu pieces, %.1f iterations in each of %lld "
      "solves, energy error %.1e\n",
      to_string(result.outcome).c_str(), result.breaks.size(),
      static_cast<long long>(result.counts.dynamic_phases), n_pieces,
      static_cast<double>(result.counts.solver_iterations) / static_cast<double>(result.counts.static_solves),
      static_cast<long long>(result.counts.static_solves), result.energy_error);
  EXPECT_EQ(result.counts.dynamic_phases, 0);
  EXPECT_GE(result.breaks.size(), 40U * index(n_layers));
  EXPECT_GT(n_pieces, 1U);
  EXPECT_LT(result.energy_error, 5e-6);
}

INSTANTIATE_TEST_SUITE_P(Releases, StableBreaks,
                         ::testing::Values(input::Release::element, input::Release::facet),
                         [](const auto& info) {
                           return info.param == input::Release::element ? "Element" : "Facet";
                         });

TEST(Hinge, ThatIsLeftOverEndsTheSampleAsSeparated) {
  // Two blocks that share a line of nodes and an adjacent column. When the column breaks, the blocks are
  // still in one piece, but the load rotates one about the other.
  auto parameters = test::brittle({0.004, 0.004, 0.012});
  parameters.time.arrest = 1e-30;
  parameters.boundaries = {test::boundary(Face::z_min, BoundaryKind::fix, {true, true, true}),
                           test::boundary(Face::z_max, BoundaryKind::force, {}, {}, {0, 0, 10})};
  const auto mesh = test::make_box(
      {.size = parameters.specimen.size, .cells = {4, 4, 12}, .removed = [](const geometry::Point& p) {
         const bool is_column = p[0] > 0.001 && p[0] < 0.002 && p[1] > 0.003;
         if (is_column || p[2] < 0.004 || p[2] > 0.008) return false;
         return p[2] < 0.006 ? p[1] > 0.001 : p[1] < 0.001;
       }});
  const parallel::Communicator self(MPI_COMM_SELF);
  const auto subdomain = test::whole(mesh);
  const auto result = run_sample(self, parameters, parameters.output, subdomain);
  fracture::BreakableBody body(subdomain, parameters.material());
  body.restore({result.breaks, {}, {}});
  const auto loads = mechanics::make_boundary_loads(self, parameters, subdomain);
  std::printf("%s after %zu breaks, %s, energy error %.1e\n", to_string(result.outcome).c_str(),
              result.breaks.size(),
              loads_are_supported(self, body, loads, fracture::piece_labels(self, body)) ? "still connected"
                                                                                         : "in two",
              result.energy_error);
  EXPECT_EQ(result.outcome, Outcome::separated);
  EXPECT_TRUE(loads_are_supported(self, body, loads, fracture::piece_labels(self, body)));
  EXPECT_EQ(result.counts.dynamic_phases, 0);
  EXPECT_LT(result.energy_error, 1e-6);
}

/// Conditions under which the hinge of the blocks offers no resistance.
struct Drive {
  const char* name;
  BoundaryKind kind;
  bool has_dead_load;
};

class LastHinge : public ::testing::TestWithParam<Drive> {};

TEST_P(LastHinge, EndsTheHistoryAtTheLastBreak) {
  // As above, but driven along one edge of the upper end, which leaves the upper block free to rotate.
  auto parameters = test::brittle({0.004, 0.004, 0.012});
  parameters.time.arrest = 1e-30;
  const Vector value = GetParam().kind == BoundaryKind::velocity ? Vector{0, 0, 1e-6} : Vector{};
  const Vector rate = GetParam().kind == BoundaryKind::velocity ? Vector{} : Vector{0, 0, 1e-6};
  auto drive = test::boundary(Face::z_max, GetParam().kind, {false, false, true}, value, rate);
  drive.region[1] = {0.0035, 0.0045};
  parameters.boundaries = {test::boundary(Face::z_min, BoundaryKind::fix, {true, true, true}), drive};
  if (GetParam().has_dead_load)
    parameters.boundaries.push_back(test::boundary(Face::z_max, BoundaryKind::force, {}, {1e-3, 0, 0}));
  const auto mesh = test::make_box(
      {.size = parameters.specimen.size, .cells = {4, 4, 12}, .removed = [](const geometry::Point& p) {
         const bool is_column = p[0] > 0.001 && p[0] < 0.002 && p[1] > 0.003;
         if (is_column || p[2] < 0.004 || p[2] > 0.008) return false;
         return p[2] < 0.006 ? p[1] > 0.001 : p[1] < 0.001;
       }});
  const parallel::Communicator self(MPI_COMM_SELF);
  const auto result = run_sample(self, parameters, parameters.output, test::whole(mesh));
  ASSERT_FALSE(result.breaks.empty());
  const HistoryRow& last = result.history.back();
  std::printf("%s after %zu breaks, history to %.4g s, break at %.4g s, work %.4g J\n",
              to_string(result.outcome).c_str(), result.breaks.size(), last.load_time,
              result.breaks.back().load_time, last.energy.external);
  EXPECT_EQ(result.outcome, Outcome::separated);
  EXPECT_EQ(last.load_time, result.breaks.back().load_time);
  EXPECT_LT(last.load_displacement, 1e-4);
  EXPECT_LE(last.energy.external, result.history[1].load * last.load_displacement);
  EXPECT_GT(last.energy.external, 0);
}

INSTANTIATE_TEST_SUITE_P(Drives, LastHinge,
                         ::testing::Values(Drive{"Displacement", BoundaryKind::displacement, false},
                                           Drive{"Velocity", BoundaryKind::velocity, false},
                                           Drive{"Mixed", BoundaryKind::displacement, true}),
                         [](const auto& info) { return std::string(info.param.name); });

TEST(RigidMotion, ThatConditionsPrescribeIsNoMechanism) {
  // Both ends move sideways together, which causes no strain, while a force pulls the bar apart.
  auto parameters = test::brittle({0.002, 0.004, 0.012});
  parameters.time.arrest = 1e-30;
  const auto run = [&](double speed) {
    parameters.boundaries = {
        test::boundary(Face::z_min, BoundaryKind::displacement, {true, true, true}, {}, {speed, 0, 0}),
        test::boundary(Face::z_max, BoundaryKind::displacement, {true, false, false}, {}, {speed, 0, 0}),
        test::boundary(Face::z_max, BoundaryKind::force, {}, {}, {0, 0, 10})};
    const auto mesh =
        test::make_box({.size = parameters.specimen.size, .cells = {2, 4, 12}, .disturbance = 0.2});
    return run_sample(parallel::Communicator(MPI_COMM_SELF), parameters, parameters.output,
                      test::whole(mesh));
  };
  const auto at_rest = run(0), moving = run(1e-6);
  EXPECT_GT(at_rest.breaks.size(), 10U);
  EXPECT_EQ(moving.outcome, Outcome::separated);
  EXPECT_EQ(moving.breaks.size(), at_rest.breaks.size());
  EXPECT_NEAR(moving.breaks.back().load_time, at_rest.breaks.back().load_time, 1e-6);
}

/// A pulled bar with some tetrahedra broken beforehand.
class DamagedBar : public ::testing::Test {
protected:
  DamagedBar()
      : mesh_(test::make_box({.size = {0.004, 0.004, 0.012}, .cells = {4, 4, 12}, .disturbance = 0.1})),
        subdomain_(test::whole(mesh_)),
        body_(subdomain_, test::epoxy()) {
    parameters_ = test::brittle({0.004, 0.004, 0.012});
    parameters_.boundaries.push_back(test::boundary(Face::z_min, BoundaryKind::fix, {true, true, true}));
    parameters_.boundaries.push_back(test::boundary(Face::z_max, BoundaryKind::force, {}, {0, 0, 10}));
    loads_ = mechanics::make_boundary_loads(self_, parameters_, subdomain_);
  }

  /// Breaks all neighbours of a tetrahedron that share at least `n` of its corners.
  void isolate(std::int32_t tetrahedron, int n) {
    const auto& own = subdomain_.tetrahedra[index(tetrahedron)];
    for (std::int32_t t = 0; t < subdomain_.n_tetrahedra(); ++t) {
      const auto& nodes = subdomain_.tetrahedra[index(t)];
      const auto shared =
          std::ranges::count_if(nodes, [&](std::int32_t a) { return std::ranges::count(own, a) > 0; });
      if (t != tetrahedron && shared >= n) body_.release(t, {}, 0, 0);
    }
  }

  std::int32_t tetrahedron_at(const geometry::Point& place) const {
    std::int32_t nearest = 0;
    double least = INFINITY;
    for (std::int32_t t = 0; t < subdomain_.n_tetrahedra(); ++t) {
      double square = 0;
      for (std::size_t i = 0; i < 3; ++i) {
        double centre = 0;
        for (const auto node : subdomain_.tetrahedra[index(t)])
          centre += subdomain_.nodes[index(node)][i] / 4;
        square += (centre - place[i]) * (centre - place[i]);
      }
      if (square < least) {
        least = square;
        nearest = t;
      }
    }
    return nearest;
  }

  double elongation() {
    auto law = test::tuler_butcher(parameters_.fracture, subdomain_);
    const QuasiStaticLoading loading(self_, body_, loads_, law, 1e-5);
    iterations_ = loading.n_iterations();
    return measure_loads(self_, body_, loads_, loading.displacement(), 0).conditions.back().position[2];
  }

  parallel::Communicator self_{MPI_COMM_SELF};
  input::Parameters parameters_;
  geometry::Realization mesh_;
  geometry::Subdomain subdomain_;
  fracture::BreakableBody body_;
  mechanics::Conditions loads_;
  std::int64_t iterations_ = 0;
};

TEST_F(DamagedBar, HasAnEquilibriumWithLooseTetrahedraInside) {
  const double intact = elongation();
  const auto before = iterations_;
  isolate(tetrahedron_at({0.002, 0.002, 0.006}), 1);
  const double damaged = elongation();
  std::printf("elongation %.6g -> %.6g mm, %lld -> %lld iterations\n", 1e3 * intact, 1e3 * damaged,
              static_cast<long long>(before), static_cast<long long>(iterations_));
  EXPECT_GT(damaged, intact);
  EXPECT_LT(damaged, 1.5 * intact);
}

TEST_F(DamagedBar, HasAnEquilibriumWithTetrahedraThatHangByAnEdgeOrACorner) {
  const double intact = elongation();
  isolate(tetrahedron_at({0.002, 0.002, 0.003}), 3);  // neighbours across edges and corners stay
  isolate(tetrahedron_at({0.002, 0.002, 0.009}), 2);  // neighbours across corners stay
  const double damaged = elongation();
  std::printf("elongation %.6g -> %.6g mm\n", 1e3 * intact, 1e3 * damaged);
  EXPECT_GT(damaged, intact);
  EXPECT_LT(damaged, 1.5 * intact);
}

}  // namespace CRACKLE_TEST_FILE
}  // namespace crackle::dynamics
