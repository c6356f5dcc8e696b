// SPDX-License-Identifier: GPL-3.0-or-later
// Bulk viscosity against exact solutions: the decay of a standing wave, and the front of a step; the step up
// to which motion is stable with it, and its energy.
#include "mechanics/elasticity.h"

#include "support/box_mesh.h"
#include "support/elastic_motion.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <numbers>

namespace crackle::dynamics {
namespace CRACKLE_TEST_FILE {

using input::BoundaryKind;
using input::Integrator;
using plane::Face;
using std::numbers::pi;

constexpr double length = 0.012;
constexpr std::array integrators{Integrator::verlet, Integrator::bilateral4};

const char* name_of(Integrator integrator) {
  return integrator == Integrator::verlet ? "verlet" : "bilateral4";
}

/// A column between walls that let plane P waves pass along z.
input::Parameters column(const input::BulkViscosity& bulk) {
  input::Parameters parameters;
  parameters.specimen.size = {0.001, 0.001, length};
  parameters.materials[0] = test::epoxy();
  for (const Face face : {Face::y_min, Face::y_max})
    parameters.boundaries.push_back(test::boundary(face, BoundaryKind::fix, {false, true, false}));
  for (const Face face : {Face::x_min, Face::x_max})
    parameters.boundaries.push_back(test::boundary(face, BoundaryKind::fix, {true, false, false}));
  parameters.damping = {.mass = 0, .bulk = bulk};
  return parameters;
}

TEST(BulkViscosity, LetsAStandingWaveDecayAsItsTheoryDoes) {
  const input::BulkViscosity bulk{0.5, 0};
  const input::Parameters parameters = column(bulk);
  const double speed = mechanics::dilatational_speed(parameters.material());
  const double wave_number = pi / length, omega = wave_number * speed, period = 2 * pi / omega;
  // All tetrahedra have the same volume: six in each cell.
  constexpr double spacing = 0.25e-3;
  const double size = std::cbrt(spacing * spacing * spacing / 6);
  const double decay = bulk.linear * speed * size * wave_number * wave_number / 2;
  const double damped = std::sqrt(omega * omega - decay * decay);
  for (const Integrator integrator : integrators) {
    test::ElasticMotion motion(test::make_box({.size = parameters.specimen.size, .cells = {4, 4, 48}}),
                               parameters, integrator);
    const double amplitude = 1e-6;
    const auto shape = [&](std::size_t n) { return std::cos(wave_number * motion.subdomain().nodes[n][2]); };
    for (std::size_t n = 0; n < motion.n_nodes(); ++n)
      motion.state().displacement.local()[3 * n + 2] = amplitude * shape(n);
    motion.start(3 * period);
    const double start = motion.energy();
    auto n_steps = static_cast<std::int64_t>(std::ceil(period / 8 / (0.5 * motion.stable_step())));
    n_steps += n_steps % 2;
    double error = 0, imbalance = 0;
    for (int moment = 1; moment <= 24; ++moment) {
      motion.advance(n_steps, period / 8 / static_cast<double>(n_steps));
      const double t = moment * period / 8;
      const double exact =
          std::exp(-decay * t) * (std::cos(damped * t) + decay / damped * std::sin(damped * t));
      double projection = 0, norm = 0;
      for (std::size_t n = 0; n < motion.n_nodes(); ++n) {
        projection += motion.mass(n) * motion.displacement(n, 2) * shape(n);
        norm += motion.mass(n) * shape(n) * shape(n);
      }
      error = std::max(error, std::abs(projection / norm / amplitude - exact));
      imbalance = std::max(imbalance, std::abs(start - motion.energy() - motion.dissipated_energy()) / start);
    }
    std::printf("%s: standing wave off by %.1e of its amplitude, of which %.3f are left; balance %.1e\n",
                name_of(integrator), error, std::exp(-3 * decay * period), imbalance);
    EXPECT_LT(error, 0.01);
    EXPECT_LT(imbalance, 2e-3);
    EXPECT_NEAR(motion.dissipated_energy() / start, 1 - std::exp(-6 * decay * period), 5e-3);
  }
}

/// The largest stress along z behind the front of a column that leaves a wall which holds its end, over the
/// exact one, density times speed times velocity.
struct Front {
  double of_tetrahedra, of_slices;
};

Front front(const input::BulkViscosity& bulk, double spacing, Integrator integrator) {
  input::Parameters parameters = column(bulk);
  parameters.boundaries.push_back(test::boundary(Face::z_min, BoundaryKind::fix, {false, false, true}));
  const input::Material& material = parameters.material();
  const double speed = mechanics::dilatational_speed(material), velocity = 1;
  test::ElasticMotion motion(test::irregular_box(parameters.specimen.size, spacing), parameters, integrator);
  for (std::size_t n = 0; n < motion.n_nodes(); ++n) motion.state().velocity.local()[3 * n + 2] = velocity;
  const double duration = 0.7 * length / speed;
  motion.start(duration);
  const auto n_steps = static_cast<std::int64_t>(std::ceil(duration / (0.9 * motion.stable_step())));
  const double exact = material.density * speed * velocity;
  Front found{};
  for (std::int64_t i = 0; i < n_steps; ++i) {
    motion.advance(1, duration / static_cast<double>(n_steps));
    const auto n_slices = static_cast<std::size_t>(length / spacing);
    std::vector<double> sum(n_slices), volume(n_slices);
    for (std::int32_t t = 0; t < motion.subdomain().n_tetrahedra(); ++t) {
      const double stress = motion.body().stress(t, motion.state().displacement.local())[2];
      found.of_tetrahedra = std::max(found.of_tetrahedra, stress / exact);
      const auto op = motion.body().operators().tetrahedra[index(t)];
      double z = 0;
      for (const auto node : op.nodes) z += motion.subdomain().nodes[index(node)][2] / 4;
      const std::size_t slice = std::min(n_slices - 1, static_cast<std::size_t>(z / length * n_slices));
      sum[slice] += op.volume * stress;
      volume[slice] += op.volume;
    }
    for (std::size_t s = 0; s < n_slices; ++s)
      if (volume[s] > 0) found.of_slices = std::max(found.of_slices, sum[s] / volume[s] / exact);
  }
  return found;
}

TEST(BulkViscosity, LowersTheOvershootBehindAFront) {
  constexpr double spacing = 0.25e-3;
  const auto measured = [&](const input::BulkViscosity& bulk, Integrator integrator) {
    const Front found = front(bulk, spacing, integrator);
    std::printf("%s, bulk = [%.2f, %.2f]: stress up to %.3f of the exact one in slices, %.3f in tetrahedra\n",
                name_of(integrator), bulk.linear, bulk.quadratic, found.of_slices, found.of_tetrahedra);
    return found;
  };
  for (const Integrator integrator : integrators) {
    const Front none = measured({0, 0}, integrator);
    const Front usual = measured({0.06, 1.2}, integrator);
    const Front strong = measured({0.5, 1.2}, integrator);
    EXPECT_GT(none.of_slices, 1.18);
    EXPECT_GT(none.of_tetrahedra, 1.3);
    // What the usual coefficients leave.
    EXPECT_LT(usual.of_slices, 1.15);
    EXPECT_LT(usual.of_tetrahedra, none.of_tetrahedra - 0.03);
    EXPECT_LT(strong.of_slices, 1.01);
    EXPECT_LT(strong.of_tetrahedra, 1.25);
    EXPECT_GT(strong.of_slices, 0.99) << "the front must pass";
  }
}

/// In one short step from a uniform rate of the volume.
TEST(BulkViscosity, DissipatesWhatItsPressureDoes) {
  const input::Material material = test::epoxy();
  const double speed = mechanics::dilatational_speed(material);
  constexpr double spacing = 0.25e-3;
  const double size = std::cbrt(spacing * spacing * spacing / 6), volume = 1e-3 * 1e-3 * length;
  const double unit_rate = speed / size;  // at which a wave crosses a tetrahedron at a strain of 1
  for (const double strain : {0.004, -0.004, -0.03}) {
    for (const input::BulkViscosity bulk : {input::BulkViscosity{0.06, 0}, input::BulkViscosity{0.06, 3}}) {
      input::Parameters parameters;
      parameters.specimen.size = {0.001, 0.001, length};
      parameters.materials[0] = material;
      parameters.damping = {.mass = 0, .bulk = bulk};
      test::ElasticMotion motion(test::make_box({.size = parameters.specimen.size, .cells = {4, 4, 48}}),
                                 parameters, Integrator::verlet);
      const double rate = strain * unit_rate;
      for (std::size_t n = 0; n < motion.n_nodes(); ++n)
        for (std::size_t i = 0; i < 3; ++i)
          motion.state().velocity.local()[3 * n + i] = rate / 3 * motion.subdomain().nodes[n][i];
      const double step = 1e-4 * motion.stable_step();
      motion.start(step);
      motion.advance(1, step);
      // The quadratic term counts up to a strain of 0.01.
      const double square = strain < 0 ? bulk.quadratic * bulk.quadratic * std::min(-strain, 0.01) : 0;
      const double exact =
          volume * (bulk.linear + square) * material.density * speed * size * rate * rate * step;
      EXPECT_NEAR(motion.dissipated_energy() / exact, 1, 2e-3) << strain << " " << bulk.quadratic;
    }
  }
}

/// A bar torn from both ends, whose driven nodes are resisted, too.
TEST(BulkViscosity, IsTheSameInEveryEngine) {
  const parallel::Communicator self(MPI_COMM_SELF);
  const auto mesh = test::make_box({.size = {0.002, 0.002, 0.006}, .cells = {3, 3, 9}, .disturbance = 0.2});
  const auto subdomain = test::whole(mesh);
  input::Parameters parameters;
  parameters.specimen.size = {0.002, 0.002, 0.006};
  for (const auto& [face, speed] : {std::pair{Face::z_min, -5.0}, {Face::z_max, 5.0}})
    parameters.boundaries.push_back(
        test::boundary(face, BoundaryKind::velocity, {true, true, true}, {0, 0, speed}));
  fracture::BreakableBody body(subdomain, test::epoxy());
  const auto loads = mechanics::make_boundary_loads(self, parameters, subdomain);
  auto law = test::unbreakable(subdomain);
  MotionContext context{&self, &body, &loads, &law};
  context.bulk_viscosity = {0.5, 1.2};
  constexpr double step = 3e-8;
  constexpr int n_steps = 200;
  std::vector<double> velocity[3], dissipated, work;
  for (int engine = 0; engine < 3; ++engine) {
    MotionState state{parallel::NodeField(self, subdomain.layout),
                      parallel::NodeField(self, subdomain.layout)};
    const auto motion =
        engine == 0   ? make_reference_motion(context, 0, state)
        : engine == 1 ? make_petsc_motion(context, 0, state)
                      : make_fixed_point_motion(context, input::Precision::double_, 0, n_steps * step, state);
    for (int i = 0; i < n_steps; ++i) motion->step(splitting(Integrator::verlet).even, step, i * step);
    motion->read(state);
    velocity[engine].assign(state.velocity.owned().begin(), state.velocity.owned().end());
    dissipated.push_back(motion->dissipated_energy());
    work.push_back(motion->external_work(n_steps * step, state));
  }
  EXPECT_GT(dissipated[0], 0.01 * work[0]);
  for (const int engine : {1, 2}) {
    EXPECT_NEAR(dissipated[index(engine)], dissipated[0], 1e-8 * dissipated[0]);
    EXPECT_NEAR(work[index(engine)], work[0], 1e-8 * work[0]);
    for (std::size_t i = 0; i < velocity[0].size(); ++i)
      EXPECT_NEAR(velocity[engine][i], velocity[0][i], 1e-7);
  }
}

/// Growth of the energy over many steps of a free body that starts with random velocities.
double growth(const input::BulkViscosity& bulk, Integrator integrator, double share_of_stable_step) {
  input::Parameters parameters = column(bulk);
  parameters.boundaries.clear();
  test::ElasticMotion motion(test::irregular_box({0.001, 0.001, 0.003}, 0.3e-3), parameters, integrator);
  RandomStream stream(1, 0, "velocity");
  for (double& v : motion.state().velocity.local()) v = stream.uniform(-1, 1);
  const double step = share_of_stable_step * motion.stable_step();
  constexpr int n_steps = 3000;
  motion.start(n_steps * step);
  const double start = motion.energy();
  double largest = 0;
  for (int i = 0; i < n_steps && largest < 10; i += 2) {
    motion.advance(2, step);
    largest = std::max(largest, motion.energy() / start);
  }
  return largest;
}

TEST(BulkViscosity, IsStableUpToTheStepComputedForIt) {
  for (const input::BulkViscosity bulk :
       {input::BulkViscosity{0.06, 1.2}, input::BulkViscosity{0.5, 0}, input::BulkViscosity{3, 0}}) {
    for (const Integrator integrator : integrators) EXPECT_LT(growth(bulk, integrator, 0.999), 2);
    EXPECT_GT(growth(bulk, Integrator::verlet, 1.04), 10) << bulk.linear;
  }
}

}  // namespace CRACKLE_TEST_FILE
}  // namespace crackle::dynamics
