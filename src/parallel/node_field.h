// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "parallel/communicator.h"
#include "parallel/node_layout.h"
#include "parallel/petsc.h"

#include <span>
#include <vector>

namespace crackle::parallel {

/// Three numbers at every node held by a rank: a ghosted PETSc vector of block size 3.
///
/// The local array holds the owned nodes first, then the ghosts, with x, y, z of each node adjacent. Ghost
/// values are those of the last update_ghosts().
class NodeField {
public:
  /// All zero. Collective; agrees before its messages.
  NodeField(const Communicator& group, const NodeLayout& layout);
  ~NodeField();
  NodeField(NodeField&& other) noexcept;
  NodeField& operator=(NodeField&&) = delete;

  std::span<double> local() { return values_; }                              ///< 3 n_local
  std::span<const double> local() const { return values_; }                  ///< 3 n_local
  std::span<double> owned() { return values_.first(n_owned_); }              ///< 3 n_owned
  std::span<const double> owned() const { return values_.first(n_owned_); }  ///< 3 n_owned

  /// Sends owned values to the ranks that hold them as ghosts. Collective; does not call check_peers()
  /// before.
  void update_ghosts();

  /// Informs PETSc that values were written through the spans, before it reads the vector.
  void mark_changed();

  /// Copies all values, ghosts included.
  void assign(const NodeField& other);

  /// The global PETSc vector, for solvers that read or write owned values.
  Vec vector() const { return global_.get(); }

private:
  VecOwner global_;
  Vec ghosted_ = nullptr;  // PETSc's local form of global_, held for the field's lifetime
  std::span<double> values_;
  std::size_t n_owned_ = 0;
};

/// The values of all nodes in the mesh's numbering on the root, empty elsewhere. Collective; agrees before
/// its messages.
/// @param owned 3 n_owned values
std::vector<double> gather_nodes(const Communicator& group, const NodeLayout& layout,
                                 std::span<const double> owned);

}  // namespace crackle::parallel
