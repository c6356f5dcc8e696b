// SPDX-License-Identifier: GPL-3.0-or-later
#include "crackle/parallel/agreement.h"

#include <cstdint>

namespace crackle::parallel {

std::string current_error() {
  try {
    throw;
  } catch (const std::exception& failure) {
    return failure.what();
  } catch (...) {
    return "unknown exception";
  }
}

void agree_on_error(const Communicator& group, const std::optional<std::string>& error) {
  int first = error ? group.rank() : group.size();
  check_mpi(MPI_Allreduce(MPI_IN_PLACE, &first, 1, MPI_INT, MPI_MIN, group.get()), "MPI_Allreduce");
  if (first == group.size()) return;
  std::string message = error.value_or("");
  int length = static_cast<int>(message.size());
  check_mpi(MPI_Bcast(&length, 1, MPI_INT, first, group.get()), "MPI_Bcast");
  message.resize(static_cast<std::size_t>(length));
  check_mpi(MPI_Bcast(message.data(), length, MPI_CHAR, first, group.get()), "MPI_Bcast");
  throw AgreedError(first, message);
}

std::string share_text(const Communicator& group, std::string text) {
  std::uint64_t length = text.size();
  check_mpi(MPI_Bcast(&length, 1, MPI_UINT64_T, 0, group.get()), "MPI_Bcast");
  text.resize(length);
  check_mpi(MPI_Bcast(text.data(), static_cast<int>(length), MPI_CHAR, 0, group.get()), "MPI_Bcast");
  return text;
}

}  // namespace crackle::parallel
