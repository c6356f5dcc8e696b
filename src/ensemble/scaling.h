// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "geometry/realization.h"

#include <vector>

/// The cost of a sample on many ranks, apart from its computation.
namespace crackle::ensemble {

/// Tetrahedra of a mesh, from its nodes and boundary triangles; to 1 % for meshes of `make_realization`.
double expected_tetrahedra(double n_nodes, double n_triangles);

/// Tetrahedra that the largest of `n_parts` compact parts computes: its share, and those at its surface that
/// other parts compute, too. Too many for slender bodies in few parts.
double compact_part(double n_tetrahedra, double n_parts);

/// The largest of the parts of a mesh. The numbers are the largest over the parts.
struct LargestPart {
  double tetrahedra = 0;  ///< computed, those of other parts included
  double ghosts = 0;      ///< nodes of other parts, received in each exchange
  double neighbours = 0;  ///< parts that own these
  double seconds = 0;     ///< to divide the mesh, on one core [s]
};

/// The part with the largest numbers of a mesh divided by METIS.
/// @param halo as geometry::split [m]
LargestPart largest_part(const geometry::Realization& realization, int n_parts, double halo = 0);

/// Sizes of parts in any number, from partitions into a few numbers of parts; between these, and for smaller
/// parts, surfaces follow powers of the number of parts, beyond them the power of compact parts.
class PartSizes {
public:
  /// @param ratio of tetrahedra of the mesh that is meant to those of this coarser one; lengths in the body
  ///   stay, so that surfaces have its power 2/3
  /// @param most_parts that are asked for
  PartSizes(const geometry::Realization& realization, double halo, int most_parts, double ratio = 1);

  double n_tetrahedra() const { return n_tetrahedra_; }
  LargestPart of(int n_parts) const;

private:
  struct Known {
    double n_parts;
    LargestPart largest;  ///< of its tetrahedra only those beyond an equal share
  };
  double n_tetrahedra_;
  std::vector<Known> known_;  ///< ascending
};

/// A cluster's network as a rank sees it: assumed, not measured. 200 Gb/s of a node are shared by 25 ranks.
struct Network {
  double latency = 2e-6;   ///< of a message [s]
  double bandwidth = 1e9;  ///< [byte/s]
};

/// Messages within a group that computes a sample, and work that ranks cannot share.
struct GroupTraffic {
  double exchanges = 0;         ///< of ghost values
  double bytes_per_ghost = 12;  ///< in an exchange
  double agreements = 0;        ///< numbers reduced over all ranks
  double repeated = 0;          ///< part of the computation that every rank does [s]

  /// Time of the messages on so many ranks [s]; 0 on one.
  double seconds(int n_ranks, const LargestPart& part, const Network& network) const;
};

}  // namespace crackle::ensemble
