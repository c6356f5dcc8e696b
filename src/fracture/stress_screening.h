// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "crackle/fracture/equivalent_stress.h"
#include "crackle/geometry/subdomain.h"
#include "crackle/mechanics/elasticity.h"
#include "crackle/mechanics/operators.h"

#include "kernels/kernels.h"

#include <cstdint>
#include <span>
#include <vector>

namespace crackle::fracture {

/// Finds the tetrahedra whose equivalent stress may be above the strength, without looking at all of
/// them in every step.
///
/// It changes by at most EquivalentStress::sensitivity() sum |u^a||b^a| when the corners move by u^a. So a
/// look at a tetrahedron with stress to spare says how far its corners must move before it can matter, and
/// the motion tells after each step between which bounds the nodes of each block moved: what all nodes
/// around a tetrahedron have in common does not strain it. A tetrahedron above the strength is never missed:
/// the bounds hold for every motion.
template <class Real>
class StressScreening {
public:
  /// @param strength of each tetrahedron [Pa]
  /// @param share of its strength above which a tetrahedron must be looked at
  /// @param displacement_quantum of the node records [m]
  /// @param nodes_per_block blocks of nodes whose movement is reported; owned nodes and ghosts in blocks of
  ///   their own
  StressScreening(const geometry::Subdomain& subdomain, const mechanics::PdsOperators& operators,
                  const mechanics::IsotropicElasticity& elasticity, const EquivalentStress& stress,
                  std::span<const double> strength, double share, double displacement_quantum,
                  std::int32_t nodes_per_block, InstructionSet instruction_set);

  /// The tetrahedra that must be looked at after a step, ascending; among them all above the share of their
  /// strength, and also broken ones.
  /// @param movement of each block of nodes since the last call
  std::span<const std::int32_t> candidates(std::span<const kernels::NodeRecord<Real>> nodes,
                                           std::span<const kernels::Movement<double>> movement);

  /// A broken tetrahedron is not looked at any more.
  void exclude(std::int32_t tetrahedron);

  /// Takes over a strength [Pa] that has not become smaller.
  void set_strength(std::int32_t tetrahedron, double strength);

private:
  struct Chunk {
    std::size_t first_group, last_group;
    std::vector<std::int32_t> blocks;  // of nodes, that its tetrahedra touch
    double clock = 0;     // how far nodes have moved so far, seen from the middle of their bounds
    double deadline = 0;  // smallest of its groups
  };

  double sensitivity(std::int32_t tetrahedron, double strength) const;
  void sort_chunks(std::span<const double> sensitivity);
  std::size_t place(std::int32_t tetrahedron) const;

  std::int32_t n_tetrahedra_;
  const mechanics::PdsOperators* operators_;
  double displacement_quantum_;
  double reference_;     // that the elastic constants are divided by [Pa]
  double per_gradient_;  // sensitivity at the reference strength
  InstructionSet instruction_set_;
  kernels::StressBound<Real> bound_;
  // The tetrahedra of a chunk are in the order of falling sensitivity, so that few groups are due often.
  std::vector<std::int16_t> tetrahedron_;  // at each place, 8 x group + lane: its number in the chunk
  std::vector<std::int16_t> place_;        // of each tetrahedron in its chunk
  std::vector<kernels::TetrahedronGroup<Real>> groups_;
  std::vector<double> deadline_;  // of each group, on its chunk's clock
  std::vector<Chunk> chunks_;
  std::vector<std::uint32_t> candidate_groups_;
  std::vector<std::int32_t> candidates_;
};

}  // namespace crackle::fracture
