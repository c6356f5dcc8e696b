// SPDX-License-Identifier: GPL-3.0-or-later
#include "crackle/dynamics/sample_setup.h"

#include "crackle/fracture/initial_strain.h"
#include "crackle/fracture/release.h"
#include "crackle/fracture/toughness.h"
#include "crackle/mechanics/rigid_motion.h"
#include "crackle/parallel/agreement.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <span>
#include <utility>

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

std::unique_ptr<fracture::Criterion> make_criterion(const parallel::Communicator& group,
                                                    const input::Parameters& parameters, std::uint64_t sample,
                                                    const fracture::BreakableBody& body,
                                                    std::span<const double> growth, double time_step) {
  auto strengths = fracture::tetrahedron_strengths(group, parameters, sample, body);
  auto impulses = fracture::impulses(group, parameters, body, strengths, growth);
  return fracture::make_criterion(parameters, std::move(strengths), time_step, std::move(impulses));
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
      release_time(fracture::release_times(ranks, input, body)) {
  refuse_overdamping(input.damping_rate(), grid);
  fracture::refuse_short_releases(ranks, part, release_time, grid.step);
  auto growth = fracture::growth_strengths(ranks, input, sample, body);
  criterion = make_criterion(ranks, input, sample, body, growth, grid.step);
  average = fracture::make_stress_average(input.fracture, body, criterion->strengths());
  // After the stable step, which depends on the stiffness alone.
  body.set_initial_strain(fracture::make_initial_strain(input, body.elasticity(), fracture::span_of(part)));
  fracture::soften_by_input(ranks, input, sample, body);
  vicinity = fracture::make_crack_vicinity(ranks, input, body, std::move(growth), *criterion, average.get());
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
