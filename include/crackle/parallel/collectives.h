// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "crackle/parallel/agreement.h"
#include "crackle/parallel/communicator.h"

#include <cstddef>
#include <numeric>
#include <span>
#include <type_traits>
#include <utility>
#include <vector>

namespace crackle::parallel {

/// The largest of all ranks' values, on every rank. Collective; does not agree() before.
inline double largest_of_all(const Communicator& group, double value) {
  check_mpi(MPI_Allreduce(MPI_IN_PLACE, &value, 1, MPI_DOUBLE, MPI_MAX, group.get()), "MPI_Allreduce");
  return value;
}

/// One value of a type as MPI sees it, so that counts of values need to fit an int, not counts of bytes.
class ValueType {
public:
  explicit ValueType(std::size_t n_bytes) {
    check_mpi(MPI_Type_contiguous(static_cast<int>(n_bytes), MPI_BYTE, &type_), "MPI_Type_contiguous");
    check_mpi(MPI_Type_commit(&type_), "MPI_Type_commit");
  }
  ~ValueType() {
    if (type_ != MPI_DATATYPE_NULL) MPI_Type_free(&type_);
  }
  ValueType(ValueType&& other) noexcept : type_(std::exchange(other.type_, MPI_DATATYPE_NULL)) {}
  ValueType(const ValueType&) = delete;
  ValueType& operator=(const ValueType&) = delete;
  MPI_Datatype get() const { return type_; }

private:
  MPI_Datatype type_ = MPI_DATATYPE_NULL;
};

/// What a gathering needs before its messages.
struct GatherBuffers {
  GatherBuffers(std::size_t value_size, int n_ranks)
      : type(value_size), counts(static_cast<std::size_t>(n_ranks)), offsets(counts.size()) {}
  ValueType type;
  std::vector<int> counts, offsets;  ///< of each rank's values
};

/// The values of all ranks in the order of the ranks, on every rank. Collective; agrees before its messages.
/// @pre fewer than 2^31 values in all
template <class Value>
std::vector<Value> gather_all(const Communicator& group, std::span<const Value> mine) {
  static_assert(std::is_trivially_copyable_v<Value>);
  const int count = static_cast<int>(mine.size());
  auto [type, counts, offsets] = agree(group, [&] { return GatherBuffers(sizeof(Value), group.size()); });
  check_mpi(MPI_Allgather(&count, 1, MPI_INT, counts.data(), 1, MPI_INT, group.get()), "MPI_Allgather");
  std::exclusive_scan(counts.begin(), counts.end(), offsets.begin(), 0);
  auto all = agree(
      group, [&] { return std::vector<Value>(static_cast<std::size_t>(offsets.back() + counts.back())); });
  check_mpi(MPI_Allgatherv(mine.data(), count, type.get(), all.data(), counts.data(), offsets.data(),
                           type.get(), group.get()),
            "MPI_Allgatherv");
  return all;
}

/// The values of all ranks in the order of the ranks, on the root; empty elsewhere. Collective; agrees before
/// its messages.
/// @pre fewer than 2^31 values in all
template <class Value>
std::vector<Value> gather_on_root(const Communicator& group, std::span<const Value> mine) {
  static_assert(std::is_trivially_copyable_v<Value>);
  const int count = static_cast<int>(mine.size());
  auto [type, counts, offsets] = agree(group, [&] { return GatherBuffers(sizeof(Value), group.size()); });
  check_mpi(MPI_Gather(&count, 1, MPI_INT, counts.data(), 1, MPI_INT, 0, group.get()), "MPI_Gather");
  std::exclusive_scan(counts.begin(), counts.end(), offsets.begin(), 0);
  std::vector<Value> all;
  agree(group, [&] {
    if (group.is_root()) all.resize(static_cast<std::size_t>(offsets.back() + counts.back()));
  });
  check_mpi(MPI_Gatherv(mine.data(), count, type.get(), all.data(), counts.data(), offsets.data(), type.get(),
                        0, group.get()),
            "MPI_Gatherv");
  return all;
}

}  // namespace crackle::parallel
