// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "common/large_vector.h"
#include "fracture/equivalent_stress.h"
#include "geometry/subdomain.h"
#include "kernels/kernels.h"
#include "mechanics/elasticity.h"
#include "mechanics/operators.h"

#include <cstdint>
#include <span>
#include <vector>

namespace crackle::fracture {

/// Finds the tetrahedra whose equivalent stress may exceed the strength, without evaluating all of them in
/// every step.
///
/// The stress changes by at most EquivalentStress::sensitivity() sum |u^a||b^a| when the corners move by u^a.
/// Hence the margin of a tetrahedron at its last evaluation determines how far its corners must move before
/// it needs the next one. After each step the motion provides bounds on the movement of the nodes of each
/// block; the common part of the movement causes no strain. No tetrahedron above the strength is ever missed,
/// since the bounds hold for every motion.
///
/// From the same strains it gives the strain energy of intact tetrahedra.
template <class Real>
class StressScreening {
public:
  /// @param strength of each tetrahedron [Pa]
  /// @param share of its strength above which a tetrahedron must be reported
  /// @param initial equivalent stress of each tetrahedron at zero displacement [Pa]; empty: none
  /// @param displacement_quantum of the node records [m]
  /// @param energy_quantum of energy() [J]
  /// @param nodes_per_block blocks of nodes whose movement is reported; owned nodes and ghosts are in
  ///   separate blocks
  StressScreening(const geometry::Subdomain& subdomain, const mechanics::PdsOperators& operators,
                  const mechanics::ElasticityField& elasticity, const EquivalentStress& stress,
                  std::span<const double> strength, double share, std::vector<double> initial,
                  double displacement_quantum, double energy_quantum, std::int32_t nodes_per_block,
                  InstructionSet instruction_set);

  /// The tetrahedra to be checked after a step, ascending: all those above the share of their strength, and
  /// possibly others, including broken ones.
  /// @param movement of each block of nodes since the last call
  std::span<const std::int32_t> candidates(std::span<const kernels::NodeRecord<Real>> nodes,
                                           std::span<const kernels::Movement<double>> movement);

  /// Excludes a broken tetrahedron from screening.
  void exclude(std::int32_t tetrahedron);

  /// Sets a strength [Pa]. If it has decreased, the tetrahedron is due at the next check.
  void set_strength(std::int32_t tetrahedron, double whole_strength);

  /// Strain energy of the counted tetrahedra that has_energy() names, without initial strain, in quanta. An
  /// integer, so that the sum over all ranks is the same for every partition.
  __int128 energy(std::span<const kernels::NodeRecord<Real>> nodes) const;
  /// Initially all counted ones, except those whose strength is out of proportion to the first.
  bool has_energy(std::int32_t tetrahedron) const;
  /// Leaves a tetrahedron out of energy() from now on.
  void leave_out_energy(std::int32_t tetrahedron);

private:
  struct Chunk {
    std::size_t first_group, last_group;
    std::vector<std::int32_t> blocks;  // of nodes touched by its tetrahedra
    double clock = 0;                  // accumulated movement of nodes relative to the centre of their bounds
    double deadline = 0;               // smallest of its groups
  };

  /// The strength left for the stress of the displacement: the equivalent stress, being convex, is at most
  /// the sum of those of the initial stress and of the rest. 0: so little that the tetrahedron is always due.
  double left_strength(std::int32_t tetrahedron, double strength) const;
  double sensitivity(std::int32_t tetrahedron, double strength) const;
  /// Stress over strength, both over their references, per strain in units of the quantum.
  double strain_scale(std::int32_t tetrahedron, double strength) const;
  void set_energy(std::int32_t tetrahedron, double strain_scale);
  void sort_chunks(std::span<const double> sensitivity);
  std::size_t place(std::int32_t tetrahedron) const;

  std::int32_t n_tetrahedra_;
  const mechanics::PdsOperators* operators_;
  double displacement_quantum_, energy_quantum_;
  const mechanics::ElasticityField* elasticity_;
  const EquivalentStress* stress_;
  double share_;
  std::vector<double> initial_;
  // Powers of two, so that the choice, which differs between ranks, changes no digit of a scaled strain.
  double reference_;        // by which the elastic constants are divided [Pa]
  double reference_shear_;  // modulus [Pa]
  InstructionSet instruction_set_;
  kernels::StressBound<Real> bound_;
  // The tetrahedra of a chunk are sorted by decreasing sensitivity, so that few groups are due often.
  std::vector<std::int16_t> tetrahedron_;  // at each place (8 x group + lane): its number in the chunk
  std::vector<std::int16_t> place_;        // of each tetrahedron in its chunk
  LargeVector<kernels::TetrahedronGroup<Real>> groups_;
  LargeVector<kernels::EnergyFactors<Real>> energy_factors_;  // of each group
  std::vector<double> deadline_;                              // of each group, on its chunk's clock
  std::vector<Chunk> chunks_;
  std::vector<std::int32_t> always_due_;  // ascending
  // The groups that are due in a call, with one place to spare, and how far each may move.
  std::vector<std::uint32_t> due_;
  std::vector<Real> room_;
  std::vector<std::int32_t> candidates_;
};

}  // namespace crackle::fracture
