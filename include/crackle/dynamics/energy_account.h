// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "crackle/dynamics/sample_result.h"
#include "crackle/fracture/breakable_body.h"
#include "crackle/mechanics/boundary_loads.h"
#include "crackle/parallel/communicator.h"
#include "crackle/parallel/node_field.h"

#include <cstddef>
#include <optional>
#include <span>
#include <string>
#include <vector>

namespace crackle::dynamics {

/// What the loads do work on, at one moment of quasi-static loading.
struct LoadState {
  std::vector<double> amplitude;  ///< of each force pattern [N or Pa]
  std::vector<double> position;   ///< its conjugate displacement: sum of weight times displacement [m or m^3]
  std::vector<double> reaction;   ///< resultant that each prescribed motion exerts [N]
  std::vector<double> travel;     ///< displacement of each prescribed motion [m]
  std::vector<Vector> absorbed = {};  ///< force that each absorbing face exerts; empty at rest [N]
};

/// Collective; equal bits for any number of ranks.
/// @param velocity of the motion, or nullptr in equilibrium
LoadState measure_loads(const parallel::Communicator& group, const fracture::BreakableBody& body,
                        const mechanics::BoundaryLoads& loads, const parallel::NodeField& displacement,
                        double time, const parallel::NodeField* velocity = nullptr);

/// Strain energy of an equilibrium, which is linear in its loads [J].
double strain_energy(const LoadState& state);

/// From the strains of all tetrahedra [J]. Collective; equal bits for any number of ranks.
/// @param displacement 3 n_local
double strain_energy(const parallel::Communicator& group, const fracture::BreakableBody& body,
                     std::span<const double> displacement);

/// The energy account of a body from its unloaded state on:
/// external work = kinetic + strain + released + dissipated. All members are collective, their values equal
/// bits for any number of ranks. [J]
class EnergyAccount {
public:
  EnergyAccount(const parallel::Communicator& group, const fracture::BreakableBody& body)
      : group_(&group), body_(&body) {}

  /// Work between two equilibria, exact when loads, stiffness and so displacements change linearly between
  /// them, or when only the stiffness changes under constant loads.
  void add_static_work(const LoadState& from, const LoadState& to);
  /// A dynamic phase that is over, or displacements that were prescribed at once.
  void add_phase(double external_work, double dissipated) {
    external_ += external_work;
    dissipated_ += dissipated;
  }

  /// The body came to rest: kinetic energy and the potential energy between `before` and the equilibrium
  /// `after` are taken out of the account's mechanical part, by 1/2 d K d with d their difference.
  void add_relaxation(double kinetic, const parallel::NodeField& before, const parallel::NodeField& after);

  /// What the account does not see by itself [J].
  struct Measured {
    double kinetic = 0;
    double strain = 0;
    double work = 0;        ///< external, of the running phase
    double dissipated = 0;  ///< in the running phase
  };
  /// The account now.
  EnergyRow row(double time, const Measured& measured) const;

private:
  const parallel::Communicator* group_;
  const fracture::BreakableBody* body_;
  double external_ = 0;
  double dissipated_ = 0;
};

/// Largest |external - kinetic - strain - released - dissipated| over the rows, relative to the largest
/// external work; 0 without rows.
double energy_error(std::span<const EnergyRow> rows);

/// Strain energy of a body that is stretched to its strength everywhere, in one direction without lateral
/// contraction [J]: what its energies are to be compared with. Equal on every rank. Collective.
/// @param strength of each tetrahedron [Pa]
double energy_at_strength(const parallel::Communicator& group, const fracture::BreakableBody& body,
                          std::span<const double> strength);

/// Why the energies of the last row show that the motion cannot be trusted: they are not finite, or, once a
/// tenth of the phase is over, the body has ten times the energy that it can have.
/// @param n_rows of the whole phase
/// @param negligible energy that rounding alone may produce [J]
std::optional<std::string> energy_fault(std::span<const EnergyRow> rows, std::size_t n_rows,
                                        double negligible = 0);

}  // namespace crackle::dynamics
