// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "parallel/agreement.h"
#include "parallel/communicator.h"
#include "parallel/message.h"

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <exception>
#include <limits>
#include <numeric>
#include <span>
#include <string>
#include <type_traits>
#include <utility>
#include <vector>

namespace crackle::parallel {

/// The MPI datatype of a number.
template <class Number>
MPI_Datatype mpi_type() {
  if constexpr (std::is_same_v<Number, int>) return MPI_INT;
  if constexpr (std::is_same_v<Number, std::int64_t>) return MPI_INT64_T;
  if constexpr (std::is_same_v<Number, double>) return MPI_DOUBLE;
}

/// MPI_Bcast of values on rank `from`; none in a group of one. Collective.
void broadcast(const Communicator& group, void* values, int n, MPI_Datatype type, int from = 0);

/// MPI_Allreduce in place; none in a group of one. Collective.
void reduce_on_all(const Communicator& group, void* values, int n, MPI_Datatype type, MPI_Op operation);

/// Element-wise reduction of the numbers of all ranks, in place on every rank. Collective; does not call
/// check_peers() before.
template <class Numbers>
requires requires {
  typename Numbers::value_type;
}
void all_reduce(const Communicator& group, Numbers& numbers, MPI_Op operation) {
  reduce_on_all(group, numbers.data(), static_cast<int>(numbers.size()),
                mpi_type<typename Numbers::value_type>(), operation);
}

/// The same for one number. Collective; does not call check_peers() before.
template <class Number>
requires std::is_arithmetic_v<Number> Number all_reduce(const Communicator& group, Number number,
                                                        MPI_Op operation) {
  std::array<Number, 1> numbers{number};
  all_reduce(group, numbers, operation);
  return numbers[0];
}

/// The maximum over all ranks, on every rank. Collective; does not call check_peers() before.
inline double largest_of_all(const Communicator& group, double value) {
  return all_reduce(group, value, MPI_MAX);
}

/// True on every rank if true on any rank. Collective; does not call check_peers() before.
inline bool any_of_all(const Communicator& group, bool is_so) {
  return all_reduce(group, is_so ? 1 : 0, MPI_MAX) != 0;
}

/// The root's value on every rank. Collective; does not call check_peers() before.
template <class Value>
requires(std::is_trivially_copyable_v<Value> && !std::is_pointer_v<Value>) Value
    share(const Communicator& group, Value value) {
  broadcast(group, &value, sizeof value, MPI_BYTE);
  return value;
}

/// The root's text or list of plain values on every rank; replaces the arguments of the others. Collective;
/// agrees before its messages.
template <class List>
List share(const Communicator& group, List list) {
  check_peers(group);
  const auto size = share<std::uint64_t>(group, list.size());
  agree(group, [&] { list.resize(size); });
  const auto bytes = std::as_writable_bytes(std::span(list));
  for (std::size_t begin = 0; begin < bytes.size(); begin += largest_message) {
    const auto part = static_cast<int>(std::min(largest_message, bytes.size() - begin));
    broadcast(group, bytes.data() + begin, part, MPI_BYTE);
  }
  return list;
}

/// MPI datatype of a single value, so that counts of values, rather than bytes, need to fit an int.
class ValueType {
public:
  ValueType() = default;  ///< for no messages
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

/// Buffers allocated before the communication of a gather.
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
  if (group.size() == 1) return agree(group, [&] { return std::vector<Value>(mine.begin(), mine.end()); });
  const int count = static_cast<int>(mine.size());
  auto buffers = agree(group, [&] { return GatherBuffers(sizeof(Value), group.size()); });
  check_mpi(MPI_Allgather(&count, 1, MPI_INT, buffers.counts.data(), 1, MPI_INT, group.get()),
            "MPI_Allgather");
  std::exclusive_scan(buffers.counts.begin(), buffers.counts.end(), buffers.offsets.begin(), 0);
  auto all = agree(group, [&] {
    return std::vector<Value>(static_cast<std::size_t>(buffers.offsets.back() + buffers.counts.back()));
  });
  check_mpi(MPI_Allgatherv(mine.data(), count, buffers.type.get(), all.data(), buffers.counts.data(),
                           buffers.offsets.data(), buffers.type.get(), group.get()),
            "MPI_Allgatherv");
  return all;
}

/// Concatenates the results of find() of all ranks, in rank order, on every rank. If nothing is found, as is
/// usual, only a small reduction is needed. Collective; does not call check_peers() before. If find() throws
/// on a rank, it propagates there and the other ranks get an empty result.
template <class Value, class Find>
std::vector<Value> gather_found(const Communicator& group, const Find& find) {
  enum Found { nothing, something, failure };
  int found = failure;
  std::vector<Value> mine;
  std::exception_ptr error;
  try {
    mine = find();
    found = mine.empty() ? nothing : something;
  } catch (...) {
    error = std::current_exception();
  }
  found = all_reduce(group, found, MPI_MAX);
  if (error) std::rethrow_exception(error);
  if (found != something) return {};
  return group.size() > 1 ? gather_all<Value>(group, mine) : mine;
}

/// The values of all ranks in the order of the ranks, on the root; empty elsewhere. Collective; agrees before
/// its messages.
/// @pre fewer than 2^31 values in all
template <class Value>
std::vector<Value> gather_on_root(const Communicator& group, std::span<const Value> mine) {
  static_assert(std::is_trivially_copyable_v<Value>);
  if (group.size() == 1) return gather_all(group, mine);
  const int count = static_cast<int>(mine.size());
  auto buffers = agree(group, [&] { return GatherBuffers(sizeof(Value), group.size()); });
  check_mpi(MPI_Gather(&count, 1, MPI_INT, buffers.counts.data(), 1, MPI_INT, 0, group.get()), "MPI_Gather");
  std::exclusive_scan(buffers.counts.begin(), buffers.counts.end(), buffers.offsets.begin(), 0);
  std::vector<Value> all;
  agree(group, [&] {
    if (group.is_root()) all.resize(static_cast<std::size_t>(buffers.offsets.back() + buffers.counts.back()));
  });
  check_mpi(MPI_Gatherv(mine.data(), count, buffers.type.get(), all.data(), buffers.counts.data(),
                        buffers.offsets.data(), buffers.type.get(), 0, group.get()),
            "MPI_Gatherv");
  return all;
}

/// The same for bytes, of which there may be too many. Collective.
/// @param what they are, for the message
/// @throws AgreedError on every rank when they are too large for one message
inline std::vector<std::byte> gather_bytes_on_root(const Communicator& group, std::span<const std::byte> mine,
                                                   const char* what,
                                                   std::int64_t largest = std::numeric_limits<int>::max()) {
  const auto total = all_reduce<std::int64_t>(group, std::ssize(mine), MPI_SUM);
  // The total is equal on every rank.
  if (total > largest) throw AgreedError(0, std::string(what) + " are too large for one message");
  return gather_on_root(group, mine);
}

}  // namespace crackle::parallel
