// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "common/index.h"
#include "common/large_vector.h"
#include "geometry/subdomain.h"
#include "kernels/kernels.h"
#include "mechanics/edges.h"
#include "mechanics/fixed_point_scale.h"

#include <array>
#include <cstdint>
#include <limits>
#include <span>
#include <utility>
#include <vector>

namespace crackle::mechanics {

/// The internal force of a subdomain edge by edge, in fixed point: six numbers for an inner edge, nine for
/// one at the surface or at a released tetrahedron. The contribution of an edge depends only on its
/// coefficients and the difference of two integers, and the sums are over integers: the force is bitwise
/// equal for every numbering, partition and instruction set.
///
/// The edges are stored by blocks of nodes, each edge in the block of its owner, so that a sweep works on
/// parts of the body that fit the cache. Blocks are numbered in sweep order: those next to ghosts come last,
/// to give the ghosts' values time to arrive.
template <class Real>
class FixedPointForce {
public:
  using Integer = kernels::Integer<Real>;
  static constexpr std::int32_t nodes_per_block = 64;
  /// Largest difference of node numbers that fits a pair of edges.
  static constexpr std::int32_t largest_reach = std::numeric_limits<std::int16_t>::max() - nodes_per_block;

  /// The blocks of nodes touched by the edges of a block. Ghosts are in separate blocks, after those of the
  /// owned nodes.
  struct Reach {
    std::int32_t last_owned;  ///< last block of owned nodes touched
    bool has_ghosts;
  };

  /// The references must outlive the object.
  /// @param inverse_mass of each owned node, relative
  /// @param residual_stiffness may change, see update()
  /// @param watches enables take_largest_contribution() in the 32-bit format
  /// @param pair_reach edges between nodes further apart in numbering use the general form, which is slower
  FixedPointForce(const geometry::Subdomain& subdomain, const PdsOperators& operators,
                  const ElasticityField& elasticity, const Edges& edges,
                  const ResidualStiffness& residual_stiffness, std::span<const double> inverse_mass,
                  const FixedPointScale& scale, InstructionSet instruction_set, bool watches = false,
                  std::int32_t pair_reach = largest_reach);

  const FixedPointScale& scale() const { return scale_; }
  std::span<kernels::NodeRecord<Real>> nodes() { return nodes_; }
  std::span<const kernels::NodeRecord<Real>> nodes() const { return nodes_; }

  std::int32_t n_blocks() const { return static_cast<std::int32_t>(blocks_.size()); }  ///< of owned nodes
  const Reach& reach(std::int32_t block) const { return blocks_[index(block)].reach; }
  std::int32_t first_node(std::int32_t block) const { return blocks_[index(block)].first_node; }
  std::int32_t block_of(std::int32_t owned_node) const {
    return block_number_[index(owned_node / nodes_per_block)];
  }
  /// The last block whose edges touch a node of this block.
  std::int32_t last_contributor(std::int32_t block) const { return blocks_[index(block)].last_contributor; }

  /// Adds the contributions of a block's edges to the nodal forces.
  void add_block(std::int32_t block);
  /// Computes the nodal forces from the displacements, in one sweep.
  void evaluate();

  /// Recomputes the coefficients of the edges of tetrahedra that lost stiffness; the cost does not depend on
  /// the size of the body.
  /// @param force_is_current the nodes hold the force of the current displacement: it is corrected
  void update(std::span<const std::int32_t> tetrahedra, bool force_is_current);

  /// Memory traffic of one force evaluation [byte]: coefficients and numbers of the edges, and each node's
  /// record once in and out.
  std::int64_t bytes_per_sweep() const;

  /// Unused slots relative to the edges stored in groups of four from one owner.
  double padding() const;

  /// The ends of edges without stiffness may part farther than a difference of displacements can tell: such
  /// an edge becomes one from a node to itself, as those do that lose their stiffness later.
  void let_ends_part();

  /// Largest difference of displacement along an edge that carries load, in quanta; valid as long as none has
  /// wrapped around.
  double largest_stretch() const;
  /// Adds the local nodes at the ends of edges that carry load and are stretched by `stretch` or more, or
  /// whose force is a quarter of what has_overflown() refuses; some of them repeatedly.
  void add_overstretched(double stretch, std::vector<std::int32_t>& nodes) const;

  /// True if a contribution in add_block() or update() has ever exceeded the format. For the 32-bit format
  /// the caller reads the processor's invalid flag instead.
  bool has_overflown() const { return !(largest_contribution_ < contribution_limit); }

  /// Largest contribution, or half of the largest difference of displacement if that is larger, since the
  /// last call, in quanta. Always available in the 64-bit format.
  double take_largest_contribution() {
    return static_cast<double>(std::exchange(largest_contribution_, Real(0)));
  }

private:
  /// Calls visit(first node, second node, largest component of the difference of displacement, largest
  /// component of the force, in quanta) for every edge that carries load, more than once for some.
  template <class Visit>
  void for_each_stretch(const Visit& visit) const;
  /// Pairs of four edges: first those with six numbers, then those with nine; finally edges that became
  /// general or exceed the reach of a pair.
  struct Block {
    std::int32_t first_node = 0;
    std::size_t first_pair = 0, first_skew_pair = 0, last_pair = 0;
    std::size_t first_skew = 0;  // in skew_
    std::vector<kernels::GeneralEdges<Real>> general;
    std::int32_t n_general = 0;
    Reach reach{};
    std::int32_t last_contributor = 0;
  };
  /// Place among the general edges of a block.
  struct GeneralPlace {
    std::int32_t block;
    std::int32_t number;  // 8 x group + lane
  };
  static constexpr Real contribution_limit = sizeof(Real) == 4 ? Real(1) : Real(0x1p50);

  using Coefficients = std::array<Real, 9>;  // S, then w

  void number_blocks();
  void lay_out_pairs(std::int32_t block, std::span<const std::vector<std::int32_t>> owned_edges);
  void find_reach();
  void append_general(std::int32_t edge, std::int32_t block);
  bool is_general(std::int32_t edge) const { return place_[index(edge)] < 0; }
  const GeneralPlace& general_place(std::int32_t edge) const {
    return general_places_[index(-1 - place_[index(edge)])];
  }
  std::int32_t block_of_edge(std::int32_t edge) const;
  Coefficients scaled(const EdgeCoupling& coupling) const;
  Coefficients coefficients(std::int32_t edge);
  void set_coefficients(std::int32_t edge, const Coefficients& values);
  /// Location of the nine numbers of edge `edge` in its pair, w only if stored there; direction is -1 if the
  /// pair stores the reversed edge.
  struct PairPlace {
    kernels::EdgeSymmetric<Real>* symmetric;
    kernels::EdgeSkew<Real>* skew;  // or nullptr
    std::size_t lane;
    Real direction;
  };
  PairPlace pair_place(std::int32_t edge);
  void see(Real contribution) {
    if (!(contribution <= largest_contribution_)) largest_contribution_ = contribution;
  }

  const geometry::Subdomain* subdomain_;
  RecentOperators operators_;
  const ElasticityField* elasticity_;
  const Edges* edges_;
  const ResidualStiffness* residual_stiffness_;
  FixedPointScale scale_;
  const kernels::Kernels<Real>* kernels_;
  LargeVector<kernels::NodeRecord<Real>> nodes_;
  LargeVector<kernels::EdgeEnds> ends_;
  LargeVector<kernels::EdgeSymmetric<Real>> symmetric_;
  LargeVector<kernels::EdgeSkew<Real>> skew_;
  std::vector<Block> blocks_;
  std::vector<std::int32_t> block_number_;  // per nodes_per_block owned nodes
  // By edge: 8 x pair + lane; or -1 - its number in general_places_.
  std::vector<std::int32_t> place_;
  std::vector<GeneralPlace> general_places_;
  Real largest_contribution_ = 0;
  bool ends_part_ = false;
};

}  // namespace crackle::mechanics
