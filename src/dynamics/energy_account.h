// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "dynamics/sample_result.h"
#include "fracture/breakable_body.h"
#include "mechanics/conditions.h"
#include "parallel/communicator.h"
#include "parallel/node_field.h"

#include <cstddef>
#include <optional>
#include <span>
#include <string>
#include <vector>

namespace crackle::dynamics {

/// Quantities needed for the work of the loads, at one moment of quasi-static loading.
struct LoadState {
  std::vector<double> amplitude = {};  ///< per force pattern [N or Pa]
  std::vector<double> position = {};  ///< conjugate displacement: sum of weight times displacement [m or m^3]
  std::vector<double> reaction = {};  ///< resultant force exerted by each prescribed motion [N]
  std::vector<double> travel = {};    ///< displacement of each prescribed motion, at factor 1 [m]
  std::vector<Vector> absorbed = {};  ///< force exerted by each absorbing face; empty at rest [N]
  // For each part of the initial strain; empty in motion, during which it is constant.
  std::vector<double> initial_factor = {};
  std::vector<double> initial_force = {};  ///< conjugate to the factor: energy per factor [J]
  std::vector<double> conjugate =
      {};  ///< force conjugate to each travel: the reactions times their factors [N]
};

/// Collective; bitwise equal for any number of ranks.
/// @param velocity of the motion, or nullptr in equilibrium
LoadState measure_loads(const parallel::Communicator& group, const fracture::BreakableBody& body,
                        const mechanics::Conditions& loads, const parallel::NodeField& displacement,
                        double time, const parallel::NodeField* velocity = nullptr);

/// Strain energy of an equilibrium that is linear in its loads and its initial strain [J].
double strain_energy(const LoadState& state);

/// From the strains of all tetrahedra [J]. Collective; bitwise equal for any number of ranks.
/// @param displacement 3 n_local
double strain_energy(const parallel::Communicator& group, const fracture::BreakableBody& body,
                     std::span<const double> displacement);

/// Half the work of the stiffness on a change of displacement, whatever the initial strain [J]. Likewise.
double change_energy(const parallel::Communicator& group, const fracture::BreakableBody& body,
                     std::span<const double> change);

/// The energy balance of a body, starting from its state without loads and initial strain: external work =
/// kinetic + strain + released + dissipated. What changes the initial strain, such as heat, does external
/// work. All members are collective and bitwise equal for any number of ranks. [J]
class EnergyAccount {
public:
  EnergyAccount(const parallel::Communicator& group, const fracture::BreakableBody& body)
      : group_(&group), body_(&body) {}

  /// Work between two equilibria; exact if loads, stiffness and hence displacements change linearly between
  /// them, or if only the stiffness changes under constant loads.
  void add_static_work(const LoadState& from, const LoadState& to);
  /// Adds a completed dynamic phase, or displacements prescribed instantaneously.
  void add_phase(double external_work, double dissipated) {
    external_ += external_work;
    dissipated_ += dissipated;
  }

  /// The body came to rest: the kinetic energy, and the potential energy between `before` and the equilibrium
  /// `after`, 1/2 d K d with their difference d, are counted as dissipated.
  void add_relaxation(double kinetic, const parallel::NodeField& before, const parallel::NodeField& after);

  /// Quantities that the account cannot compute itself [J].
  struct Measured {
    double kinetic = 0;
    double strain = 0;
    double work = 0;        ///< external work of the running phase
    double dissipated = 0;  ///< dissipated in the running phase
  };
  /// The current balance.
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

/// Reference energy: the strain energy of the body if it were stretched to its strength everywhere, in
/// uniaxial strain [J]. Equal on every rank. Collective.
/// @param strength of each tetrahedron [Pa]
double energy_at_strength(const parallel::Communicator& group, const fracture::BreakableBody& body,
                          std::span<const double> strength);

/// Why the energies of the last row show that the motion is invalid: they are not finite, or, after a tenth
/// of the phase, exceed ten times the available energy.
/// @param n_rows of the whole phase
/// @param negligible energy that rounding alone may produce [J]
std::optional<std::string> energy_fault(std::span<const EnergyRow> rows, std::size_t n_rows,
                                        double negligible = 0);

}  // namespace crackle::dynamics
