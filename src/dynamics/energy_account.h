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
#include <utility>
#include <vector>

namespace crackle::dynamics {

/// A force and the displacement on which it does work, or other quantities whose product is a work [J].
struct Work {
  double force = 0;
  double displacement = 0;
  bool is_driven = false;  ///< the displacement is prescribed, rather than the force
};

/// The loads and motion of a condition of the input at one moment.
struct ConditionState {
  Vector applied{};       ///< force of its load on the body [N]
  Vector reaction{};      ///< that of its motion or absorbing face; the latter in motion only [N]
  Vector displacement{};  ///< prescribed at factor 1, or the mean over the load, weighted with a factor [m]
  double amplitude = 0;   ///< of its load; the same in all components of a pressure [N or Pa]
  Vector position{};      ///< sums of the load's weights times displacements [m or m^3]

  /// On the body; a component has a load or a reaction [N].
  Vector force() const {
    Vector sum = applied;
    for (std::size_t i = 0; i < 3; ++i)
      if (reaction[i] != 0) sum[i] += reaction[i];
    return sum;
  }
};

/// The loads on a body at one moment, as its terms measure them.
struct LoadState {
  std::vector<ConditionState> conditions = {};
  std::vector<Work> works = {};
  std::vector<Record> records = {};
  std::vector<ToolState> tools = {};
  /// Forces of tools on driven components, by 3 node + component, of this rank: what drives them bears these
  /// too [N].
  std::vector<std::pair<std::size_t, double>> borne = {};
  double stored = 0;  ///< in the body and its terms; set in equilibrium only [J]
};

/// Adds the forces that the loads apply at a time, without their works. Local.
void apply_loads(const mechanics::Conditions& loads, double time, LoadState& state);
/// Adds the loads with their works. Collective; bitwise equal for any number of ranks.
void measure_forces(const parallel::Communicator& group, const mechanics::Conditions& loads,
                    const parallel::NodeField& displacement, double time, LoadState& state);
/// Adds the prescribed motions with their works; they also bear what the state says. Likewise.
void measure_motions(const parallel::Communicator& group, const fracture::BreakableBody& body,
                     const mechanics::Conditions& loads, const parallel::NodeField& displacement, double time,
                     LoadState& state);
/// Both.
LoadState measure_loads(const parallel::Communicator& group, const fracture::BreakableBody& body,
                        const mechanics::Conditions& loads, const parallel::NodeField& displacement,
                        double time);
/// Adds the works of the initial strain at its time. Likewise.
void measure_initial_strain(const parallel::Communicator& group, const fracture::BreakableBody& body,
                            const parallel::NodeField& displacement, LoadState& state);
/// Adds the forces of absorbing faces. Likewise.
void measure_absorbers(const parallel::Communicator& group, const mechanics::Conditions& loads,
                       const parallel::NodeField& velocity, LoadState& state);

/// Strain energy of an equilibrium that is linear in its loads and its initial strain [J].
double strain_energy(const LoadState& state);

/// Work between two equilibria; exact if loads, stiffness and hence displacements change linearly between
/// them, or if only the stiffness changes under constant loads [J].
double static_work(const LoadState& from, const LoadState& to);

/// From the strains of all tetrahedra [J]. Collective; bitwise equal for any number of ranks.
/// @param displacement 3 n_local
double strain_energy(const parallel::Communicator& group, const fracture::BreakableBody& body,
                     std::span<const double> displacement);

/// Half the work of the stiffness, with that of springs, on a change of displacement, whatever the initial
/// strain [J]. Likewise.
double change_energy(const parallel::Communicator& group, const fracture::BreakableBody& body,
                     std::span<const mechanics::NodeStiffness> springs, std::span<const double> change);

/// The energy balance of a body, starting from its state without loads and initial strain: external work =
/// kinetic + strain + released + dissipated. What changes the initial strain, such as heat, does external
/// work. All members are collective and bitwise equal for any number of ranks. [J]
class EnergyAccount {
public:
  EnergyAccount(const parallel::Communicator& group, const fracture::BreakableBody& body)
      : group_(&group), body_(&body) {}

  /// Adds the static_work().
  void add_static_work(const LoadState& from, const LoadState& to);
  /// Adds a completed dynamic phase, or displacements prescribed instantaneously.
  void add_phase(double external_work, double dissipated) {
    external_ += external_work;
    dissipated_ += dissipated;
  }

  /// The body came to rest, at the cost of this energy [J].
  void add_relaxation(double lost) { dissipated_ += lost; }

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
