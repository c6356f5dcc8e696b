// SPDX-License-Identifier: GPL-3.0-or-later
// The hot loops of explicit dynamics, in fixed point: state and sums are integers, so sums do not depend on
// their order. Compiled once for each instruction set; the results are bitwise equal.
#pragma once

#include "common/instruction_set.h"

#include <cstddef>
#include <cstdint>
#include <type_traits>

namespace crackle::kernels {

/// The integer type for a real type: float is the format "mixed", double is "double".
template <class Real>
using Integer = std::conditional_t<sizeof(Real) == 4, std::int32_t, std::int64_t>;

/// a + b with wrap-around.
template <class Number>
Number sum(Number a, Number b) {
  using Unsigned = std::make_unsigned_t<Number>;
  return static_cast<Number>(static_cast<Unsigned>(a) + static_cast<Unsigned>(b));
}

/// a - b with wrap-around.
template <class Number>
Number difference(Number a, Number b) {
  using Unsigned = std::make_unsigned_t<Number>;
  return static_cast<Number>(static_cast<Unsigned>(a) - static_cast<Unsigned>(b));
}

/// Data of a node used by the force loop, stored contiguously. Displacement and force are in quanta.
template <class Real>
struct alignas(8 * sizeof(Real)) NodeRecord {
  Integer<Real> displacement[3];  ///< low digits, which wrap around
  Real inverse_mass;              ///< times a reference mass, by which the kick's factor is divided
  Integer<Real> force[4];         ///< internal force; the last is 0
};

template <class Real>
struct alignas(4 * sizeof(Real)) Velocity {
  Integer<Real> value[4];  ///< in quanta; the last is 0
};

/// Bounds on the displacement changes of some nodes, by component, in quanta; the last is 0.
template <class Real>
struct alignas(4 * sizeof(Real)) Movement {
  Real low[4];
  Real high[4];
};

/// A kick v += kick / m * f, after which f = 0 unless kept, and a drift u += drift * v.
template <class Real>
struct NodeUpdate {
  bool has_kick = false, has_drift = false;
  bool keeps_force = false;
  Real kick = 0, drift = 0;
  Integer<Real> (*kept)[4] = nullptr;  ///< receives each u before the drift, and the inverse mass; or nullptr
};

template <class Real>
struct NodeExtremes {
  Real force;               ///< largest |f| in the kick
  Movement<Real> movement;  ///< bounds on the changes of u in the drift, before rounding
};

/// Eight edges in two groups of four; each group starts at one owner node. Padding is an edge from its owner
/// to itself.
struct EdgeEnds {
  std::int32_t owner;         ///< of the first group
  std::int16_t second_owner;  ///< of the second group; this and the targets are relative to the first owner
  std::int16_t target[8];
};
/// K_ab = S + [w]x, in quanta of force per quantum of displacement: S as xx, yy, zz, yz, xz, xy of each edge.
template <class Real>
struct alignas(8 * sizeof(Real)) EdgeSymmetric {
  Real s[6][8];
};
template <class Real>
struct alignas(8 * sizeof(Real)) EdgeSkew {
  Real w[3][8];
};

/// Eight edges between any nodes.
template <class Real>
struct alignas(8 * sizeof(Real)) GeneralEdges {
  Real s[6][8];
  Real w[3][8];
  std::int32_t first[8];
  std::int32_t second[8];
};

/// Eight tetrahedra, with the data of the breaking check.
template <class Real>
struct alignas(8 * sizeof(Real)) TetrahedronGroup {
  /// b^1, b^2, b^3, times the displacement quantum, the reference strength over the tetrahedron's own, and
  /// its stiffness over the reference.
  Real gradient[9][8];
  /// Bound on the change of equivalent stress over strength if no corner moves by more than one quantum.
  Real sensitivity[8];
  std::int32_t corner[4][8];
};

/// The strain energies of the eight tetrahedra of a group, in quanta, from their strains e as scaled there:
/// trace tr(e)^2 + square e : e.
template <class Real>
struct alignas(8 * sizeof(Real)) EnergyFactors {
  Real trace[8];
  Real square[8];
};

/// A sum of integers, high 2^50 + low.
struct WideSum {
  std::int64_t high;
  std::int64_t low;
};

/// Factors of an upper bound on the equivalent stress over a reference strength: of tr(epsilon), of which the
/// one that gives the larger bound counts, and of sqrt(e : e / 2) with the deviator e of the strain.
template <class Real>
struct StressBound {
  Real trace[2];
  Real deviator;
};

template <class Real>
struct Kernels {
  /// f_a += S (u_b - u_a), f_b -= the same.
  /// @return largest contribution or half difference of displacement if watched; otherwise 0
  Real (*add_symmetric_edges)(const EdgeEnds* ends, const EdgeSymmetric<Real>* symmetric, std::size_t n,
                              NodeRecord<Real>* nodes);
  /// f_a += S d + w x d, f_b += -S d + w x d, with d = u_b - u_a.
  Real (*add_skew_edges)(const EdgeEnds* ends, const EdgeSymmetric<Real>* symmetric,
                         const EdgeSkew<Real>* skew, std::size_t n, NodeRecord<Real>* nodes);
  Real (*add_general_edges)(const GeneralEdges<Real>* edges, std::size_t n, NodeRecord<Real>* nodes);
  /// The kick and the drift of an update, in one pass over the nodes.
  /// @param n at least 1
  NodeExtremes<Real> (*update)(NodeRecord<Real>* nodes, Velocity<Real>* velocity, std::size_t n,
                               const NodeUpdate<Real>& update);
  /// For each due group: how far its corners may move, relative to some common motion, before a tetrahedron's
  /// equivalent stress can exceed the strength; 0 if one may exceed it now. Those far from it have some large
  /// number.
  /// @param due numbers of groups
  void (*check)(const TetrahedronGroup<Real>* groups, const std::uint32_t* due, std::size_t n,
                const NodeRecord<Real>* nodes, StressBound<Real> bound, Real* room);
  /// The strain energies of the tetrahedra of some groups, each rounded to an integer below 2^100.
  /// @param n at most 4,096
  WideSum (*energy)(const TetrahedronGroup<Real>* groups, const EnergyFactors<Real>* factors, std::size_t n,
                    const NodeRecord<Real>* nodes);
};

/// @pre the machine has the instruction set
/// @param watches the edge functions return the largest contribution. Those of double always do; for float,
///   the processor's invalid flag indicates an overflow at no cost
template <class Real>
const Kernels<Real>& kernels(InstructionSet set, bool watches = false);

}  // namespace crackle::kernels
