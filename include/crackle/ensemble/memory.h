// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "crackle/ensemble/group_layout.h"
#include "crackle/geometry/body.h"
#include "crackle/input/parameters.h"
#include "crackle/parallel/communicator.h"

#include <filesystem>
#include <optional>
#include <string>

/// The memory that a run takes, and whether it is there.
namespace crackle::ensemble {

/// Largest memory that one rank takes [byte], the program included.
struct MemoryDemand {
  double master;  ///< makes realizations; where the layout is shared it computes too
  double root;    ///< of a group
  double member;  ///< of a group, not its root
};

/// The layout of a sample that all ranks share.
GroupLayout one_group(int n_ranks);

/// Within a quarter of what is measured, for bodies that take more than the program itself.
/// @param n_tetrahedra of one realization, and the nodes that they have
MemoryDemand memory_demand(const input::Parameters& parameters, double n_nodes, double n_tetrahedra,
                           const GroupLayout& layout);

/// As memory_demand, before any mesh is made: from the number of mother points that are expected, or that
/// the file of mesh.points has.
MemoryDemand expected_memory_demand(const input::Parameters& parameters, const geometry::Body& body,
                                    const GroupLayout& layout);

/// Of a program that makes one realization and does no more with it [byte]; before any mesh is made.
double expected_mesh_memory(const input::Parameters& parameters, const geometry::Body& body);

/// Memory that processes may still take on this node, and what limits it.
struct AvailableMemory {
  double bytes;       ///< infinity where nothing can be found out
  std::string limit;  ///< "memory of the node", "control group /slurm/..."
};

/// MemAvailable, or what the control group of this process or one above it (SLURM, containers) leaves, where
/// that is less. Cached files do not count as taken.
/// @param root of the file system with /proc and /sys
AvailableMemory available_memory(const std::filesystem::path& root = "/");

/// A message with both numbers, when `needed` bytes more are not available; nothing when they are.
/// @param whose "making the mesh", "3 ranks on node7"
std::optional<std::string> shortage(double needed, const std::string& whose,
                                    const AvailableMemory& available);

/// @throws std::runtime_error with what shortage says and what to do, when there is one
void check_available(double needed, const std::string& whose, const AvailableMemory& available);

/// Refuses a run whose ranks together need more than is available on one of their nodes. Collective.
/// @param has_work on the root: whether there is anything to compute; otherwise nothing is refused
/// @throws the same parallel::AgreedError on every rank, naming the node and both numbers
void check_memory(const parallel::Communicator& world, const input::Parameters& parameters,
                  const geometry::Body& body, const GroupLayout& layout, bool has_work);

}  // namespace crackle::ensemble
