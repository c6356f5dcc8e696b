// SPDX-License-Identifier: GPL-3.0-or-later
// A command whose last rank fails unnoticed while the others wait for it.
#include "parallel_command.h"

#include <mpi.h>

#include <stdexcept>

int main(int argc, char** argv) {
  MPI_Init(&argc, &argv);
  int status = 0;
  {
    const crackle::parallel::Communicator world(MPI_COMM_WORLD);
    status = crackle::apps::end_collectively(world, [&] {
      if (world.rank() == world.size() - 1) throw std::runtime_error("this rank is out of order");
      MPI_Barrier(world.get());
      return 0;
    });
  }
  MPI_Finalize();
  return status;
}
