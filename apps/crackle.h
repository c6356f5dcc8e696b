// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "commands.h"

#include <mpi.h>

#include <functional>

namespace crackle::apps {

/// Runs one command line: what the program does between the start and the end of its process. It keeps no
/// state, never ends the process while there is one rank, and can be called again. Collective over `ranks`
/// once MPI is started.
///
/// Results go to standard output, from the root; messages, progress and the one line for each error go to
/// standard error. A failure that only one of several ranks knows of ends them all by MPI_Abort.
/// @param ranks share the command; where MPI is not started, this process works alone
/// @param words the command line, which begins with the program's name
/// @param start_mpi starts MPI and PETSc unless they are started. It is called at once for a command that
/// needs
///   them, or when a launcher has started other ranks; by `check` just before it tries a sample; otherwise
///   never, so that other commands work where MPI cannot start. Failure is a std::runtime_error.
/// @return the exit status, an ExitStatus
int crackle(MPI_Comm ranks, const CommandLine& words, const std::function<void()>& start_mpi);

}  // namespace crackle::apps
