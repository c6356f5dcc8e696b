// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "crackle/dynamics/integrator.h"
#include "crackle/dynamics/stable_step.h"
#include "crackle/fracture/breakable_body.h"
#include "crackle/fracture/criterion.h"
#include "crackle/fracture/stress_average.h"
#include "crackle/geometry/subdomain.h"
#include "crackle/input/parameters.h"
#include "crackle/mechanics/boundary_loads.h"
#include "crackle/parallel/communicator.h"

#include <cstdint>
#include <memory>
#include <string>
#include <vector>

namespace crackle::dynamics {

/// What a sample starts from: its intact body, loads, strengths and time step. Whoever computes a sample, or
/// only asks whether it can be computed, starts with this.
struct SampleSetup {
  /// Collective. The references must outlive the object.
  /// @param sample its number, which the random field of the material depends on
  /// @throws std::runtime_error where a boundary condition has no place on the mesh, the input's time step is
  ///   above the stable one, or the damping is too strong for the time step
  SampleSetup(const parallel::Communicator& group, const input::Parameters& parameters,
              const geometry::Subdomain& subdomain, std::uint64_t sample);

  /// The rigid motions that nothing holds, such as "turn about x". Collective.
  std::vector<std::string> free_motions() const;

  /// @throws parallel::AgreedError on every rank when free_motions() has any: there is no equilibrium then.
  ///   Collective.
  void refuse_free_body() const;

  const parallel::Communicator& group;
  const input::Parameters& parameters;
  const geometry::Subdomain& subdomain;
  fracture::BreakableBody body;
  mechanics::BoundaryLoads loads;
  const Splitting& splitting;
  double stable_step;  ///< [s]
  TimeGrid grid;
  std::unique_ptr<fracture::Criterion> criterion;
  std::unique_ptr<fracture::StressAverage> average;  ///< or none
};

}  // namespace crackle::dynamics
