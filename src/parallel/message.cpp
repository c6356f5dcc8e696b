// SPDX-License-Identifier: GPL-3.0-or-later
#include "parallel/message.h"

#include "parallel/sleeping_wait.h"

#include <algorithm>
#include <stdexcept>
#include <string>

namespace crackle::parallel {

void send_bytes(const Communicator& group, std::span<const std::byte> bytes, int destination, int tag,
                std::size_t piece) {
  const std::uint64_t length = bytes.size();
  check_mpi(MPI_Send(&length, 1, MPI_UINT64_T, destination, tag, group.get()), "MPI_Send");
  for (std::size_t first = 0; first < bytes.size(); first += piece) {
    const std::size_t count = std::min(piece, bytes.size() - first);
    check_mpi(
        MPI_Send(bytes.data() + first, static_cast<int>(count), MPI_BYTE, destination, tag, group.get()),
        "MPI_Send");
  }
}

std::size_t receive_length(const Communicator& group, int source, int tag, std::size_t element) {
  wait_for_message(group, source, tag);
  std::uint64_t length = 0;
  check_mpi(MPI_Recv(&length, 1, MPI_UINT64_T, source, tag, group.get(), MPI_STATUS_IGNORE), "MPI_Recv");
  if (length % element != 0) {
    throw std::runtime_error("a message of " + std::to_string(length) + " bytes came where elements of " +
                             std::to_string(element) + " bytes were expected");
  }
  return length;
}

void receive_pieces(const Communicator& group, std::span<std::byte> bytes, int source, int tag,
                    std::size_t piece) {
  for (std::size_t first = 0; first < bytes.size(); first += piece) {
    const std::size_t count = std::min(piece, bytes.size() - first);
    wait_for_message(group, source, tag);
    check_mpi(MPI_Recv(bytes.data() + first, static_cast<int>(count), MPI_BYTE, source, tag, group.get(),
                       MPI_STATUS_IGNORE),
              "MPI_Recv");
  }
}

}  // namespace crackle::parallel
