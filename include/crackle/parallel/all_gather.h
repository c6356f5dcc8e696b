// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "crackle/parallel/communicator.h"

#include <cstddef>
#include <type_traits>
#include <vector>

namespace crackle::parallel {

/// The values of all ranks, in the order of the ranks, on every rank; a few thousand at most. Collective.
template <class Value>
requires std::is_trivially_copyable_v<Value> std::vector<Value> all_gather_values(
    const Communicator& group, const std::vector<Value>& mine) {
  const int n_bytes = static_cast<int>(mine.size() * sizeof(Value));
  std::vector<int> counts(static_cast<std::size_t>(group.size())), offsets(counts.size(), 0);
  check_mpi(MPI_Allgather(&n_bytes, 1, MPI_INT, counts.data(), 1, MPI_INT, group.get()), "MPI_Allgather");
  for (std::size_t r = 1; r < counts.size(); ++r) offsets[r] = offsets[r - 1] + counts[r - 1];
  std::vector<Value> all(static_cast<std::size_t>(offsets.back() + counts.back()) / sizeof(Value));
  check_mpi(MPI_Allgatherv(mine.data(), n_bytes, MPI_BYTE, all.data(), counts.data(), offsets.data(),
                           MPI_BYTE, group.get()),
            "MPI_Allgatherv");
  return all;
}

}  // namespace crackle::parallel
