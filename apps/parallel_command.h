// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "commands.h"

#include <functional>

/// What the commands that run on many ranks share.
namespace crackle::apps {

/// Columns of the terminal that shows standard output, 0 when it goes somewhere else. Looks through the
/// pseudo-terminal that mpirun puts between itself and its processes.
int terminal_width();

/// Runs `work`. A failure that the other ranks do not know of ends the whole program: they would wait for
/// ever.
int end_together(const parallel::Communicator& world, const std::function<int()>& work);

}  // namespace crackle::apps
