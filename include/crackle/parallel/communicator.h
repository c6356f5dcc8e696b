// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <mpi.h>

namespace crackle::parallel {

/// @throws std::runtime_error with MPI's message unless `code` is MPI_SUCCESS
void check_mpi(int code, const char* call);

/// Move-only owner of a duplicated or split MPI communicator. Errors are returned, not fatal.
class Communicator {
public:
  /// Duplicates `communicator`. Collective over it.
  explicit Communicator(MPI_Comm communicator);
  ~Communicator();
  Communicator(Communicator&& other) noexcept;
  Communicator& operator=(Communicator&& other) noexcept;
  Communicator(const Communicator&) = delete;
  Communicator& operator=(const Communicator&) = delete;

  /// The sub-communicator of the ranks with the same non-negative color. Collective.
  Communicator split(int color, int key) const;

  MPI_Comm get() const { return communicator_; }
  int rank() const { return rank_; }
  int size() const { return size_; }
  bool is_root() const { return rank_ == 0; }

private:
  Communicator() = default;
  MPI_Comm communicator_ = MPI_COMM_NULL;
  int rank_ = 0;
  int size_ = 1;
};

}  // namespace crackle::parallel
