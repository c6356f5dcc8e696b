// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "parallel/communicator.h"

#include <cstddef>
#include <span>
#include <type_traits>
#include <vector>

/// Messages of any length between ranks of the same architecture.
namespace crackle::parallel {

/// MPI counts are int; longer arrays are sent in pieces of this size [byte].
inline constexpr std::size_t largest_message = std::size_t{1} << 30;

/// Sends the length and then the bytes, in pieces of at most `piece` bytes.
void send_bytes(const Communicator& group, std::span<const std::byte> bytes, int destination, int tag,
                std::size_t piece = largest_message);

/// Length in bytes of the array that send_bytes sends next; sleeps until it arrives.
/// @throws std::runtime_error when the length is not a multiple of `element`
std::size_t receive_length(const Communicator& group, int source, int tag, std::size_t element);

/// Fills `bytes`, whose length came from receive_length; sleeps until each piece arrives.
void receive_pieces(const Communicator& group, std::span<std::byte> bytes, int source, int tag,
                    std::size_t piece = largest_message);

template <class T>
void send_array(const Communicator& group, const std::vector<T>& values, int destination, int tag,
                std::size_t piece = largest_message) {
  static_assert(std::is_trivially_copyable_v<T>);
  send_bytes(group, std::as_bytes(std::span(values)), destination, tag, piece);
}

template <class T>
std::vector<T> receive_array(const Communicator& group, int source, int tag,
                             std::size_t piece = largest_message) {
  static_assert(std::is_trivially_copyable_v<T>);
  std::vector<T> values(receive_length(group, source, tag, sizeof(T)) / sizeof(T));
  receive_pieces(group, std::as_writable_bytes(std::span(values)), source, tag, piece);
  return values;
}

}  // namespace crackle::parallel
