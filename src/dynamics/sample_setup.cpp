// SPDX-License-Identifier: GPL-3.0-or-later
#include "dynamics/sample_setup.h"

#include "dynamics/contact_stiffness.h"
#include "dynamics/separation.h"
#include "dynamics/tool_term.h"
#include "fracture/initial_strain.h"
#include "fracture/release_time.h"
#include "geometry/mother_points.h"
#include "mechanics/rigid_motion.h"
#include "parallel/agreement.h"
#include "parallel/collectives.h"

#include "terms.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <utility>
#include <vector>

namespace crackle::dynamics {

namespace {

/// The trapezoidal rule reproduces the decay up to 1; from 2 on it would reverse velocities.
void refuse_overdamping(double rate, const TimeGrid& grid) {
  if (rate * grid.step <= 1) return;
  throw parallel::AgreedError(0, fmt::format("damping.mass = {:.3g} 1/s times the time step of {:.4g} ns "
                                             "exceeds 1; give less than {:.3g} 1/s, or a shorter time.step",
                                             rate, 1e9 * grid.step, 1 / grid.step));
}

mechanics::Conditions all_loads(const parallel::Communicator& group, const input::Model& model,
                                const fracture::BreakableBody& body) {
  mechanics::Conditions loads =
      mechanics::make_boundary_loads(group, model, body.subdomain(), body.material());
  mechanics::add_body_forces(group, model.body_forces(), body.subdomain(), body.operators(), loads);
  return loads;
}

/// With the tools of the input.
std::vector<MakeTerm> all_terms(const input::Model& model, std::vector<MakeTerm> terms) {
  if (!model.tools.empty()) terms.push_back(make_tools(model.tools));
  return terms;
}

/// The square ends of slots that count as cracks: where cracks start by means around nodes, those narrow
/// enough. The spacings of points from a file are not known.
std::vector<fracture::SquareEnd> crack_ends(const input::Model& model) {
  auto ends = fracture::square_ends(model.specimen);
  if (!model.fracture_of(0).nucleates_by_means() || ends.empty() || model.mesh.points) return ends;
  const auto body = geometry::make_body(model);
  const geometry::SpacingField spacing(*body, model.mesh);
  std::erase_if(
      ends, [&](const fracture::SquareEnd& end) { return fracture::is_high(end, spacing, body->size()[0]); });
  return ends;
}

}  // namespace

SampleSetup::SampleSetup(const parallel::Communicator& ranks, const input::Model& input,
                         const geometry::Subdomain& part, std::uint64_t sample, std::vector<MakeTerm> terms)
    : group(ranks),
      model(input),
      subdomain(part),
      body(part, fracture::make_material_field(input, sample, fracture::span_of(part)), nullptr,
           input.surface_contact() ? input::Contact::frictionless : input::Contact::none,
           input.surface_contact().value_or(input::SurfaceContact{}).friction),
      waves(fracture::slowest_waves(ranks, input, body)),
      loads(all_loads(ranks, input, body)),
      more_terms(all_terms(input, std::move(terms))),
      mass_scaling(scale_masses(ranks, input, part, body.operators(), body.material(), body.force())),
      contact(input.any_contact()
                  ? contact_scale(ranks, part, body.operators(), body.force(), *input.any_contact())
                  : ContactScale{}),
      splitting(dynamics::splitting(input.time.integrator)),
      stable_step(dynamics::stable_step(ranks, input.time.integrator, input.bulk_viscosity(), part,
                                        body.operators(), body.material(), body.force(), set_supports())),
      grid(choose_time_grid(input.time, stable_step)),
      law(ranks, input, sample, body, {grid.step, stable_step},
          {.ends = parallel::agree(ranks, [&] { return crack_ends(input); })}) {
  refuse_overdamping(input.damping_rate(), grid);
  fracture::refuse_short_releases(ranks, part, body.release_law().time(), grid.step);
  // Contact acts from where the first cut closes, or from the start of a dynamic phase.
  body.residual_stiffness().let_contacts_act(false);
  // After the stable step, which depends on the stiffness alone.
  body.set_initial_strain(fracture::make_initial_strain(input, body.elasticity(), fracture::span_of(part)));
}

MotionContext SampleSetup::motion_context() {
  return {
      &group,     &body,  &loads, &law, model.damping_rate(), model.stress_varies(), model.bulk_viscosity(),
      more_terms, contact};
}

std::vector<mechanics::NodeStiffness> SampleSetup::set_supports() {
  std::vector<mechanics::NodeStiffness> springs;
  if (contact.rate > 0) springs = largest_contact(group, model, subdomain, body.operators(), contact);
  if (more_terms.empty()) return springs;
  MotionContext context{&group, &body, &loads, nullptr};
  context.more_terms = more_terms;
  context.contact = contact;
  const Terms terms(context);
  for (const auto& term : terms) term->add_supports(loads.supports);
  parallel::check_peers(group);
  loads.has_supports = parallel::any_of_all(group, !loads.supports.empty());
  const auto most = terms.stiffest(std::vector<double>(3 * subdomain.nodes.size()));
  springs.insert(springs.end(), most.begin(), most.end());
  return springs;
}

std::vector<std::string> SampleSetup::free_motions() const {
  return mechanics::free_rigid_motions(group, subdomain, loads);
}

void SampleSetup::refuse_free_body() const {
  const bool has_cracks = !model.specimen.cracks.empty() || !model.flaws.empty();
  if (has_cracks && is_separated(group, body, loads))
    throw parallel::AgreedError(
        0, "the pre-cracks cut the body apart: leave material around them, or use start = \"rest\"");
  const std::vector<std::string> free = free_motions();
  if (free.empty()) return;
  throw parallel::AgreedError(
      0, fmt::format("rigid-body motion is not constrained ({}): add supports, or use start = \"rest\"",
                     fmt::join(free, ", ")));
}

}  // namespace crackle::dynamics
