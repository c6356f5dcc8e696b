// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "commands.h"
#include "crackle/common/real.h"

#include <functional>
#include <optional>
#include <span>
#include <string>
#include <string_view>

/// What the commands that run on many ranks share.
namespace crackle::apps {

/// Columns of the terminal that shows an output stream (STDOUT_FILENO or STDERR_FILENO), 0 when it goes
/// somewhere else. Looks through the pseudo-terminal that mpirun puts between itself and its processes.
int terminal_width(int stream);

/// Seconds of a time such as "8h", "30 min" or "90" (seconds), or as SLURM writes it: M:SS, H:MM:SS,
/// D-H, D-HH:MM or D-HH:MM:SS. Nothing for another text.
std::optional<double> duration(std::string_view text);

/// When a command parks what is under way, and how often it keeps checkpoints.
struct ParkingOptions {
  std::optional<double> time_limit;       ///< [s]
  double checkpoint_interval = infinity;  ///< [s]
};

/// Declares --time-limit and --checkpoint-interval.
void add_parking_options(CLI::App& command, ParkingOptions& options);

/// Looks whether SLURM has started this program several times, each by itself, where it was to start the
/// ranks of one run: srun without what MPI needs of it.
/// @param is_whole the command computes all samples, which only one of these programs can do
/// @throws std::runtime_error then; where each may have its own samples, or a script or shell has started the
/// program, one line on standard error says so
void check_tasks(const parallel::Communicator& world, bool is_whole);

/// What signals do; for the end of a command's help.
inline constexpr const char* signals_help =
    "SIGTERM, SIGINT, SIGUSR1: park samples under way and stop; a second signal ends the program at once.";

/// For the end of a command's help.
inline constexpr const char* crash_help =
    "128 or more: a rank crashed; complete results are kept, continue with --resume.\n";

/// Words as a shell takes them.
std::string shell_line(std::span<const std::string> words);

/// The command line that continues with what this one left: without --resume, --retry-failed and
/// --overwrite, and with `option` at its end. What started the ranks is no part of it.
std::string continuation(const CommandLine& typed, const std::string& option);

/// Runs `work`. An AgreedError passes; any other failure, of which the other ranks do not know and would wait
/// forever, is notified and ends the whole program with the status internal_failure.
int end_together(const parallel::Communicator& world, const std::function<int()>& work);

}  // namespace crackle::apps
