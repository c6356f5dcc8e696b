// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "crackle/parallel/communicator.h"

#include <numeric>
#include <span>
#include <type_traits>
#include <vector>

namespace crackle::parallel {

/// The largest of all ranks' values, on every rank. Collective.
inline double largest_of_all(const Communicator& group, double value) {
  check_mpi(MPI_Allreduce(MPI_IN_PLACE, &value, 1, MPI_DOUBLE, MPI_MAX, group.get()), "MPI_Allreduce");
  return value;
}

/// The values of all ranks in the order of the ranks, on every rank. Collective.
/// @pre below 2 GiB in all
template <class Value>
std::vector<Value> gather_all(const Communicator& group, std::span<const Value> mine) {
  static_assert(std::is_trivially_copyable_v<Value>);
  const int n_bytes = static_cast<int>(mine.size_bytes());
  std::vector<int> counts(static_cast<std::size_t>(group.size())), offsets(counts.size());
  check_mpi(MPI_Allgather(&n_bytes, 1, MPI_INT, counts.data(), 1, MPI_INT, group.get()), "MPI_Allgather");
  std::exclusive_scan(counts.begin(), counts.end(), offsets.begin(), 0);
  std::vector<Value> all(static_cast<std::size_t>(offsets.back() + counts.back()) / sizeof(Value));
  check_mpi(MPI_Allgatherv(mine.data(), n_bytes, MPI_BYTE, all.data(), counts.data(), offsets.data(),
                           MPI_BYTE, group.get()),
            "MPI_Allgatherv");
  return all;
}

/// The values of all ranks in the order of the ranks, on the root; empty elsewhere. Collective.
/// @pre below 2 GiB in all
template <class Value>
std::vector<Value> gather_on_root(const Communicator& group, std::span<const Value> mine) {
  static_assert(std::is_trivially_copyable_v<Value>);
  const int n_bytes = static_cast<int>(mine.size_bytes());
  std::vector<int> counts(static_cast<std::size_t>(group.size())), offsets(counts.size());
  check_mpi(MPI_Gather(&n_bytes, 1, MPI_INT, counts.data(), 1, MPI_INT, 0, group.get()), "MPI_Gather");
  std::exclusive_scan(counts.begin(), counts.end(), offsets.begin(), 0);
  std::vector<Value> all;
  if (group.is_root()) all.resize(static_cast<std::size_t>(offsets.back() + counts.back()) / sizeof(Value));
  check_mpi(MPI_Gatherv(mine.data(), n_bytes, MPI_BYTE, all.data(), counts.data(), offsets.data(), MPI_BYTE,
                        0, group.get()),
            "MPI_Gatherv");
  return all;
}

}  // namespace crackle::parallel
