// SPDX-License-Identifier: GPL-3.0-or-later
#include "parallel/sleeping_wait.h"

#include <algorithm>
#include <thread>

namespace crackle::parallel {

void BackOff::sleep() {
  std::this_thread::sleep_for(pause_);
  pause_ = std::min(2 * pause_, longest);
}

std::optional<MPI_Status> poll_message(const Communicator& group, int source, int tag) {
  int arrived = 0;
  MPI_Status status;
  check_mpi(MPI_Iprobe(source, tag, group.get(), &arrived, &status), "MPI_Iprobe");
  if (arrived == 0) return std::nullopt;
  return status;
}

MPI_Status wait_for_message(const Communicator& group, int source, int tag) {
  BackOff back_off;
  for (;;) {
    if (const auto status = poll_message(group, source, tag)) return *status;
    back_off.sleep();
  }
}

void barrier_asleep(const Communicator& group) {
  if (group.size() == 1) return;
  MPI_Request request = MPI_REQUEST_NULL;
  check_mpi(MPI_Ibarrier(group.get(), &request), "MPI_Ibarrier");
  BackOff back_off;
  for (;;) {
    int complete = 0;
    check_mpi(MPI_Test(&request, &complete, MPI_STATUS_IGNORE), "MPI_Test");
    if (complete != 0) return;
    back_off.sleep();
  }
}

}  // namespace crackle::parallel
