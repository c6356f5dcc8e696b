// SPDX-License-Identifier: GPL-3.0-or-later
// The program: signals, the start and end of MPI and PETSc, and one command line.
#include "crackle.h"
#include "ensemble/stop_request.h"
#include "runtime.h"

#include <csignal>
#include <optional>

int main(int argc, char** argv) {
  using namespace crackle;
  // Exceeding a file size limit becomes a write error, like a full disk.
  std::signal(SIGXFSZ, SIG_IGN);
  const apps::CommandLine words(argv, argv + argc);
  const bool can_suspend = argc > 1 && (words[1] == "run" || words[1] == "sample");
  // From the start, since the launcher forwards signals as soon as the ranks exist.
  if (can_suspend) ensemble::watch_stop_signals();
  std::optional<apps::Runtime> runtime;
  return apps::crackle(MPI_COMM_WORLD, words, [&] {
    if (!runtime) runtime.emplace();
    if (can_suspend) ensemble::watch_stop_signals();  // MPI has installed its own handlers
  });
}
