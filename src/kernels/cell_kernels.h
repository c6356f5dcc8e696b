// SPDX-License-Identifier: GPL-3.0-or-later
// The hot loops of the static solver besides those over edges. Compiled once for each instruction set; the
// results are bitwise equal.
#pragma once

#include "common/instruction_set.h"

#include "kernels.h"

#include <cstddef>
#include <cstdint>

namespace crackle::kernels {

/// The rigid motions of a cell: three translations, three rotations. Each triple is padded to four numbers,
/// to fit a register.
inline constexpr std::size_t n_motions = 6;
constexpr std::size_t lane_of(std::size_t motion) {
  return motion < 3 ? motion : motion + 1;
}
struct alignas(64) CellNumbers {
  double value[8];
};
struct alignas(64) CellIntegers {
  std::int64_t value[8];
};

/// Number of cells per node; some may have zero weight.
inline constexpr std::size_t n_shares = 4;
struct CellGroup {
  std::int32_t cell[n_shares];
  std::int32_t n_nodes;  ///< belonging to these cells
};
struct alignas(32) NodeInCells {
  float weight[n_shares];  ///< whole numbers
  float place[3];
  std::int32_t node;
};
/// The nodes, ordered by their cells.
struct NodesInCells {
  const CellGroup* groups;
  std::size_t n_groups;
  const NodeInCells* nodes;
};

/// A corner's share in the motion of a cell.
struct CornerShare {
  double gradient[3];
  double free[3];  ///< the share's weight, or 0 for a constrained component
  double arm[3];   ///< from the cell's centre
  int cell;        ///< index among the tetrahedron's cells
};

struct CellKernels {
  /// Sets the displacements of n nodes to scale times u, rounded to integers, and the forces to 0.
  void (*set_displacements)(NodeRecord<float>* nodes, std::size_t n, const float* u, double scale);
  /// force = quantum times the nodes' forces.
  /// @return displacement . force, in quanta
  __int128 (*get_forces)(const NodeRecord<float>* nodes, std::size_t n, double quantum, float* force);
  /// sums[cell] += weight (r, place x r) over the nodes, with each of the six numbers rounded to an integer.
  /// @param load r = scale times it, three numbers of each node
  void (*add_loads)(NodesInCells nodes, const float* load, double scale, CellNumbers* sums);
  /// result = B load + t + r x place, with t and r the sums of weight times the cells' motions.
  /// @param block the six numbers of B in the order of the nodes: xx, yy, zz, yz, xz, xy
  /// @return the bits of the largest magnitude in the result
  std::int32_t (*add_motions)(NodesInCells nodes, const float* load, const float* block,
                              const CellNumbers* motion, float* result);
  /// The strains of a tetrahedron due to the motions of its cells, by component, and the corresponding
  /// stresses.
  /// @param strain, stress six per cell
  /// @param stiffness stress per strain, 6 x 6
  void (*find_strains)(const CornerShare* shares, std::size_t n_shares, std::size_t n_cells,
                       const double (*stiffness)[6], CellNumbers* strain, CellNumbers* stress);
  /// block[m] += stress in motion m . strain in all motions, rounded to integers below 2^51.
  void (*add_energies)(const CellNumbers* stress, const CellNumbers* strain, CellIntegers* block);
};

/// @pre the machine has the instruction set
const CellKernels& cell_kernels(InstructionSet set);

}  // namespace crackle::kernels
