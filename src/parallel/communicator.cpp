// SPDX-License-Identifier: GPL-3.0-or-later
#include "parallel/communicator.h"

#include "parallel/collectives.h"

#include <array>
#include <stdexcept>
#include <string>

namespace crackle::parallel {

void check_mpi(int code, const char* call) {
  if (code == MPI_SUCCESS) return;
  std::array<char, MPI_MAX_ERROR_STRING> text{};
  int length = 0;
  MPI_Error_string(code, text.data(), &length);
  throw std::runtime_error(std::string(call) + ": " +
                           std::string(text.data(), static_cast<std::size_t>(length)));
}

Communicator::Communicator(MPI_Comm communicator) {
  int is_started = 0;
  check_mpi(MPI_Initialized(&is_started), "MPI_Initialized");
  if (is_started == 0) return;
  check_mpi(MPI_Comm_dup(communicator, &communicator_), "MPI_Comm_dup");
  set_up();
}

void Communicator::set_up() {
  check_mpi(MPI_Comm_set_errhandler(communicator_, MPI_ERRORS_RETURN), "MPI_Comm_set_errhandler");
  check_mpi(MPI_Comm_rank(communicator_, &rank_), "MPI_Comm_rank");
  check_mpi(MPI_Comm_size(communicator_, &size_), "MPI_Comm_size");
}

Communicator::~Communicator() {
  if (communicator_ != MPI_COMM_NULL) MPI_Comm_free(&communicator_);
}

Communicator& Communicator::operator=(Communicator&& other) noexcept {
  std::swap(communicator_, other.communicator_);
  std::swap(rank_, other.rank_);
  std::swap(size_, other.size_);
  std::swap(stage_, other.stage_);
  std::swap(on_stage_, other.on_stage_);
  return *this;
}

Communicator Communicator::split(int color, int key) const {
  Communicator part;
  check_mpi(MPI_Comm_split(communicator_, color, key, &part.communicator_), "MPI_Comm_split");
  part.set_up();
  return part;
}

void broadcast(const Communicator& group, void* values, int n, MPI_Datatype type, int from) {
  if (group.size() > 1) check_mpi(MPI_Bcast(values, n, type, from, group.get()), "MPI_Bcast");
}

void reduce_on_all(const Communicator& group, void* values, int n, MPI_Datatype type, MPI_Op operation) {
  if (group.size() > 1)
    check_mpi(MPI_Allreduce(MPI_IN_PLACE, values, n, type, operation, group.get()), "MPI_Allreduce");
}

}  // namespace crackle::parallel
