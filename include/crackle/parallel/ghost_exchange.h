// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "crackle/geometry/subdomain.h"
#include "crackle/parallel/communicator.h"
#include "crackle/parallel/petsc.h"

#include <array>
#include <cstdint>
#include <span>
#include <vector>

namespace crackle::parallel {

/// Sends three integers of each owned node to the ranks that hold the node as a ghost, with computation
/// between the beginning and the end (PETSc's star forest).
template <class Integer>
class GhostExchange {
public:
  using Value = std::array<Integer, 3>;

  /// Collective; agrees before its messages.
  GhostExchange(const Communicator& group, const geometry::Subdomain& subdomain);
  ~GhostExchange();
  GhostExchange(const GhostExchange&) = delete;
  GhostExchange& operator=(const GhostExchange&) = delete;

  /// The owned nodes whose values travel, ascending.
  std::span<const std::int32_t> sent_nodes() const { return sent_nodes_; }
  /// One for each of sent_nodes(); to be filled before begin().
  std::span<Value> sent() { return sent_; }
  /// One for each ghost, in the order of the local numbers; valid after end().
  std::span<const Value> received() const { return received_; }

  void begin();  ///< Collective.
  void end();    ///< Collective.

  std::int64_t n_exchanges() const { return n_exchanges_; }
  std::int64_t bytes_per_exchange() const {
    return static_cast<std::int64_t>(received_.size() * sizeof(Value));
  }

private:
  PetscOwner<PetscSF, PetscSFDestroy> forest_;
  MPI_Datatype type_ = MPI_DATATYPE_NULL;
  std::vector<std::int32_t> sent_nodes_;
  std::vector<Value> sent_;
  std::vector<Value> received_;
  std::int64_t n_exchanges_ = 0;
};

}  // namespace crackle::parallel
