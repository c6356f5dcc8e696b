// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "common/index.h"
#include "parallel/collectives.h"
#include "parallel/communicator.h"
#include "parallel/node_layout.h"
#include "parallel/petsc.h"

#include <algorithm>
#include <cstdint>
#include <span>
#include <type_traits>
#include <vector>

namespace crackle::parallel {

/// The owned nodes sent to other ranks, and the star forest (PETSc) that transfers them to their ghosts; none
/// of these in a group of one.
class GhostForest {
public:
  /// Collective; agrees before its messages.
  GhostForest(const Communicator& group, const NodeLayout& layout);

  std::span<const std::int32_t> sent_nodes() const { return sent_nodes_; }  ///< owned, ascending
  std::size_t n_ghosts() const { return n_ghosts_; }
  void begin(MPI_Datatype type, const void* sent, void* received) const;  ///< Collective.
  void end(MPI_Datatype type, const void* sent, void* received) const;    ///< Collective.

private:
  std::vector<std::int32_t> sent_nodes_;
  std::size_t n_ghosts_ = 0;
  PetscOwner<PetscSF, PetscSFDestroy> forest_;
};

/// Sends a value of each owned node to the ranks that hold the node as a ghost, allowing computation between
/// begin() and end().
template <class Value>
requires std::is_trivially_copyable_v<Value>
class GhostExchange {
public:
  /// Collective; agrees before its messages.
  GhostExchange(const Communicator& group, const NodeLayout& layout)
      : type_(group.size() > 1 ? ValueType(sizeof(Value)) : ValueType()), forest_(group, layout) {
    agree(group, [&] {
      sent_.resize(forest_.sent_nodes().size());
      received_.resize(forest_.n_ghosts());
    });
    // The first exchange allocates, later ones do not.
    begin();
    end();
    n_exchanges_ = 0;
  }

  /// The owned nodes whose values are sent, ascending.
  std::span<const std::int32_t> sent_nodes() const { return forest_.sent_nodes(); }
  /// One value for each of sent_nodes(); fill before begin().
  std::span<Value> sent() { return sent_; }
  /// One value per ghost, in the order of local numbers; valid after end().
  std::span<const Value> received() const { return received_; }

  void begin() { forest_.begin(type_.get(), sent_.data(), received_.data()); }  ///< Collective.
  /// Collective.
  void end() {
    forest_.end(type_.get(), sent_.data(), received_.data());
    ++n_exchanges_;
  }

  /// Updates the ghosts among all values held by this rank. Collective; does not call check_peers() before.
  void update(std::span<Value> local) {
    for (std::size_t i = 0; i < sent_.size(); ++i) sent_[i] = local[index(sent_nodes()[i])];
    begin();
    end();
    std::ranges::copy(received_, local.end() - static_cast<std::ptrdiff_t>(received_.size()));
  }

  std::int64_t n_exchanges() const { return n_exchanges_; }
  std::int64_t bytes_per_exchange() const {
    return static_cast<std::int64_t>(received_.size() * sizeof(Value));
  }

private:
  ValueType type_;
  GhostForest forest_;
  std::vector<Value> sent_;
  std::vector<Value> received_;
  std::int64_t n_exchanges_ = 0;
};

}  // namespace crackle::parallel
