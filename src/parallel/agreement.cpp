// SPDX-License-Identifier: GPL-3.0-or-later
#include "crackle/parallel/agreement.h"

namespace crackle::parallel {

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

}  // namespace crackle::parallel
