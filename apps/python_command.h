// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "commands.h"

namespace crackle::apps {

/// Commands that the Python package `crackle` carries out: the root starts Python on it with the words of the
/// command line and waits for its end. Python asks this program, given by CRACKLE, for what follows from
/// files of an ensemble.
/// @param typed as by the user, its options already checked
/// @return the exit status
/// @throws std::runtime_error when there is no Python, or no package beside the program
int run_in_python(const parallel::Communicator& world, const CommandLine& typed);

}  // namespace crackle::apps
