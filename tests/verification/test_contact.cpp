// SPDX-License-Identifier: GPL-3.0-or-later
// A bar is broken in two and pushed together again: with contact the crack carries compression, and nothing
// else.
#include "common/index.h"
#include "dynamics/explicit_phase.h"
#include "dynamics/stable_step.h"
#include "mechanics/elasticity.h"

#include "support/box_mesh.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdio>

namespace crackle::dynamics {
namespace CRACKLE_TEST_FILE {

using input::BoundaryKind;
using input::Contact;
using plane::Face;

struct Pushed {
  double reaction;      ///< at the driven end, relative to an intact bar
  double energy_error;  ///< relative to the work
};

/// Moves the end of a bar that is broken in the middle by `strain` times its length, slowly compared with its
/// waves.
Pushed push(double strain, Contact contact, input::Release release, bool is_broken = true) {
  input::Parameters parameters;
  const geometry::Point size{0.002, 0.002, 0.01};
  parameters.specimen.size = size;
  parameters.materials[0] = test::epoxy();
  const double duration = 120e-6;
  auto moved =
      test::boundary(Face::z_max, BoundaryKind::displacement, {false, false, true}, {0, 0, strain * size[2]});
  moved.history = {{0, 0}, {duration, 1}};
  parameters.boundaries = {test::boundary(Face::z_min, BoundaryKind::fix, {true, true, true}), moved};
  const auto mesh = test::make_box({.size = size, .cells = {3, 3, 15}, .disturbance = 0.1});
  const auto subdomain = test::whole(mesh);
  const parallel::Communicator self(MPI_COMM_SELF);
  fracture::BreakableBody body(subdomain, parameters.material(), fracture::make_release({.release = release}),
                               contact);
  const auto loads = mechanics::make_boundary_loads(self, parameters, subdomain);
  const auto is_upper = [&](std::int32_t n) { return subdomain.nodes[index(n)][2] > 0.0049; };
  const mechanics::Symmetric tension{-0.38e-3, -0.38e-3, 1e-3, 0, 0, 0};
  for (std::int32_t t = 0; is_broken && t < subdomain.n_tetrahedra(); ++t) {
    const auto n = std::ranges::count_if(subdomain.tetrahedra[index(t)], is_upper);
    if (n > 0 && n < 4) body.release(t, tension, 0, 0);
  }
  body.release_bridges(self, 0, 0, [&](std::int32_t) { return mechanics::Symmetric{}; });

  auto law = test::unbreakable(subdomain);
  MotionState state{parallel::NodeField(self, subdomain.layout), parallel::NodeField(self, subdomain.layout)};
  const MotionContext context{&self, &body, &loads, &law};
  const auto& map = splitting(input::Integrator::bilateral4);
  PhaseOptions options;
  input::Time time;
  time.duration = duration;
  const double omega = largest_frequency(self, subdomain, body.operators(), body.force());
  options.grid = choose_time_grid(time, 0.5 * map.stability_limit / omega);
  const EnergyAccount account(self, body);
  const auto motion = make_fixed_point_motion(context, input::Precision::double_, 0, duration, state);
  auto phase = run_explicit_phase(context, *motion, map, account, 0, options, state);
  // The energy of the prior breaks is not part of this motion.
  for (auto& row : phase.energy) row.released = 0;
  const double unbroken = parameters.materials[0].youngs_modulus * size[0] * size[1] * std::abs(strain);
  return {
      std::abs(measure_loads(self, body, loads, state.displacement, duration).conditions.back().reaction[2]) /
          unbroken,
      energy_error(phase.energy)};
}

TEST(Contact, OfABrokenBarCarriesCompressionOnly) {
  for (const auto release : {input::Release::element, input::Release::facet}) {
    const char* name = release == input::Release::element ? "element" : "facet";
    const Pushed whole = push(-1e-3, Contact::none, release, false);
    const Pushed with = push(-1e-3, Contact::frictionless, release);
    const Pushed pulled = push(1e-3, Contact::frictionless, release);
    const Pushed without = push(-1e-3, Contact::none, release);
    std::printf(
        "%s: pushed back, the end carries %.3f of the unbroken bar's force with contact (energy error "
        "%.1e), %.1e without; pulled %.1e\n",
        name, with.reaction / whole.reaction, with.energy_error, without.reaction, pulled.reaction);
    EXPECT_NEAR(with.reaction, whole.reaction, 0.1 * whole.reaction);
    EXPECT_LT(with.energy_error, 1e-3);
    EXPECT_LT(without.reaction, 0.05);
    EXPECT_LT(pulled.reaction, 0.05);
  }
}

}  // namespace CRACKLE_TEST_FILE
}  // namespace crackle::dynamics
