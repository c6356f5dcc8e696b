// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "ensemble/group.h"
#include "geometry/body.h"
#include "input/study.h"
#include "parallel/communicator.h"

#include <filesystem>
#include <optional>
#include <string>

/// Memory demand of a run, and whether it can be met.
namespace crackle::ensemble {

/// Peak memory of one rank [byte], including the program itself.
struct MemoryDemand {
  double master;   ///< makes realizations; with a shared layout it also computes
  double root;     ///< of a group
  double member;   ///< of a group, not its root
  double idle;     ///< of no group
  double placing;  ///< at least, of the first most_placing ranks: of those that place shared mother points

  double of_rank(const GroupLayout& layout, int rank) const;
};

/// Accurate to 25 % for bodies that need more memory than the program itself.
/// @param n_nodes, n_tetrahedra of one realization
/// @param largest_part tetrahedra that the largest part computes; empty: those of a compact one
MemoryDemand memory_demand(const input::Study& study, double n_nodes, double n_tetrahedra,
                           const GroupLayout& layout, std::optional<double> largest_part = {});

/// As memory_demand, before any mesh exists: from the expected number of mother points, or the number in the
/// file of mesh.points.
MemoryDemand expected_memory_demand(const input::Study& study, const geometry::Body& body,
                                    const GroupLayout& layout);

/// Memory of a program that only makes one realization [byte]; before any mesh exists.
double expected_mesh_memory(const input::Model& model, const geometry::Body& body);

/// Memory that processes can still allocate on this node, and what limits it.
struct AvailableMemory {
  double bytes;       ///< infinity if unknown
  std::string limit;  ///< "memory of the node", "control group /slurm/..."
};

/// MemAvailable, or less if the control group of this process or one of its ancestors (SLURM, containers)
/// leaves less. The page cache does not count as used.
AvailableMemory available_memory(const std::filesystem::path& root = "/");

/// A message with both numbers if `needed` more bytes are not available; empty otherwise.
/// @param whose "making the mesh", "3 ranks on node7"
std::optional<std::string> shortage(double needed, const std::string& whose,
                                    const AvailableMemory& available);

/// @throws std::runtime_error with the message of shortage and advice, when memory is short
void check_available(double needed, const std::string& whose, const AvailableMemory& available);

/// Refuses a run whose ranks together need more memory than is available on one of their nodes. Collective.
/// @param has_work on the root: false skips the check, as there is nothing to compute
void check_memory(const parallel::Communicator& world, const input::Study& study, const geometry::Body& body,
                  const GroupLayout& layout, bool has_work);

}  // namespace crackle::ensemble
