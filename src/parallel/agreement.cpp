// SPDX-License-Identifier: GPL-3.0-or-later
#include "parallel/agreement.h"

#include "common/printable.h"
#include "parallel/collectives.h"

#include <algorithm>
#include <array>
#include <cstdint>
#include <new>

namespace crackle::parallel {

std::string current_error() {
  try {
    throw;
  } catch (const std::exception& failure) {
    return reason_of(failure);
  } catch (...) {
    return "unknown exception";
  }
}

std::string current_error(const Communicator& group) noexcept {
  try {
    const std::string stage = group.stage();
    return stage.empty() ? current_error() : stage + ": " + current_error();
  } catch (...) {
    return {};
  }
}

void agree_on_error(const Communicator& group, const std::optional<std::string>& error) {
  int first = error ? group.rank() : group.size();
  reduce_on_all(group, &first, 1, MPI_INT, MPI_MIN);
  if (first == group.size()) return;
  std::uint64_t length = error ? error->size() : 0;
  broadcast(group, &length, 1, MPI_UINT64_T, first);
  // The failure may be a failed allocation, so no allocation is allowed before all ranks have the message.
  std::string message;
  std::array<char, 1024> piece{};
  for (std::size_t begin = 0; begin < length; begin += piece.size()) {
    const std::size_t n = std::min(piece.size(), static_cast<std::size_t>(length) - begin);
    if (first == group.rank()) error->copy(piece.data(), n, begin);
    broadcast(group, piece.data(), static_cast<int>(n), MPI_CHAR, first);
    try {
      message.append(piece.data(), n);
    } catch (const std::bad_alloc&) {
    }
  }
  try {
    throw AgreedError(first, message);
  } catch (const std::bad_alloc&) {
    throw AgreedError(first, {});
  }
}

}  // namespace crackle::parallel
