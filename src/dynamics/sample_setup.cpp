// SPDX-License-Identifier: GPL-3.0-or-later
#include "crackle/dynamics/sample_setup.h"

#include "crackle/fracture/initial_strain.h"
#include "crackle/fracture/toughness.h"
#include "crackle/mechanics/rigid_motion.h"
#include "crackle/parallel/agreement.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

namespace crackle::dynamics {

namespace {

/// The trapezoidal rule reproduces the decay up to 1; from 2 on it would reverse velocities.
void refuse_overdamping(double rate, const TimeGrid& grid) {
  if (rate * grid.step <= 1) return;
  throw parallel::AgreedError(0, fmt::format("damping.mass = {:.3g} 1/s times the time step of {:.4g} ns "
                                             "exceeds 1; give less than {:.3g} 1/s, or a shorter time.step",
                                             rate, 1e9 * grid.step, 1 / grid.step));
}

mechanics::Conditions all_loads(const parallel::Communicator& group, const input::Parameters& parameters,
                                const fracture::BreakableBody& body) {
  mechanics::Conditions loads =
      mechanics::make_boundary_loads(group, parameters, body.subdomain(), body.material());
  mechanics::add_body_forces(group, parameters, body.subdomain(), body.operators(), loads);
  return loads;
}

}  // namespace

SampleSetup::SampleSetup(const parallel::Communicator& ranks, const input::Parameters& input,
                         const geometry::Subdomain& part, std::uint64_t sample)
    : group(ranks),
      parameters(input),
      subdomain(part),
      body(part, fracture::make_material_field(input, sample, fracture::span_of(part)),
           input.fracture.release, input.fracture.contact),
      waves(fracture::slowest_waves(ranks, input, body)),
      loads(all_loads(ranks, input, body)),
      splitting(dynamics::splitting(input.time.integrator)),
      stable_step(dynamics::stable_step(ranks, input, part, body.operators(), body.material(), body.force())),
      grid(choose_time_grid(input.time, stable_step)),
      criterion(fracture::make_criterion(
          input, fracture::tetrahedron_strengths(ranks, input, sample, body), grid.step,
          fracture::fracture_field(input, fracture::span_of(part), &input::Fracture::impulse))),
      average(fracture::make_stress_average(input.fracture, body, criterion->strengths())) {
  refuse_overdamping(input.damping_rate(), grid);
  // After the stable step, which depends on the stiffness alone.
  body.set_initial_strain(fracture::make_initial_strain(input, body.elasticity(), fracture::span_of(part)));
  fracture::soften_by_input(ranks, input, sample, body);
  vicinity = fracture::make_crack_vicinity(ranks, input, sample, body, *criterion, average.get());
}

std::vector<std::string> SampleSetup::free_motions() const {
  return mechanics::free_rigid_motions(group, subdomain, loads);
}

void SampleSetup::refuse_free_body() const {
  const std::vector<std::string> free = free_motions();
  if (free.empty()) return;
  throw parallel::AgreedError(
      0, fmt::format("rigid-body motion is not constrained ({}): add supports, or use start = \"rest\"",
                     fmt::join(free, ", ")));
}

}  // namespace crackle::dynamics
