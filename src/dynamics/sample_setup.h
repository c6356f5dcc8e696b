// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "dynamics/integrator.h"
#include "dynamics/mass_scaling.h"
#include "dynamics/moving_body.h"
#include "dynamics/stable_step.h"
#include "fracture/breakable_body.h"
#include "fracture/fracture_law.h"
#include "fracture/material_field.h"
#include "geometry/subdomain.h"
#include "input/model.h"
#include "mechanics/conditions.h"
#include "parallel/communicator.h"

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

namespace crackle::dynamics {

/// The initial state of a sample: intact body, loads, strengths and time step. Shared by sample runs and by
/// checks of whether a sample can be computed.
struct SampleSetup {
  /// Collective. The references must outlive the object.
  /// @param sample its number, on which the material's random field depends
  /// @param terms beside those of the input
  /// @throws std::runtime_error when a boundary condition selects no part of the mesh, the input's time step
  ///   exceeds the stable one, or the damping is too strong for the time step
  SampleSetup(const parallel::Communicator& group, const input::Model& model,
              const geometry::Subdomain& subdomain, std::uint64_t sample, std::vector<MakeTerm> terms = {});

  /// The unconstrained rigid-body motions, such as "turn about x". Collective.
  std::vector<std::string> free_motions() const;

  /// Collective. @throws parallel::AgreedError on every rank when free_motions() is not empty, since there is
  /// no equilibrium then
  void refuse_free_body() const;

  /// For the sample's dynamic phases.
  MotionContext motion_context();

  const parallel::Communicator& group;
  const input::Model& model;
  const geometry::Subdomain& subdomain;
  fracture::BreakableBody body;
  fracture::BodyWaves waves;
  mechanics::Conditions loads;
  std::vector<MakeTerm> more_terms;
  std::optional<MassScaling> mass_scaling;  ///< of the body, after the loads took the weights of its masses
  ContactScale contact;
  const Splitting& splitting;
  double stable_step;  ///< [s]
  TimeGrid grid;
  fracture::FractureLaw law;

private:
  /// Lets the other terms hold the body. @return their stiffness, with that of contact. Collective.
  std::vector<mechanics::NodeStiffness> set_supports();
};

}  // namespace crackle::dynamics
