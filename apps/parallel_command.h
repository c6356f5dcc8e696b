// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "commands.h"
#include "common/real.h"
#include "ensemble/case.h"

#include <functional>
#include <optional>
#include <span>
#include <string>
#include <string_view>

/// Shared by the commands that run on many ranks.
namespace crackle::apps {

/// Columns of the terminal that shows an output stream (STDOUT_FILENO or STDERR_FILENO), 0 if it is
/// redirected. Looks through the pseudo-terminal that mpirun puts between itself and its processes.
int terminal_width(int stream);

/// Parses a time such as "8h", "30 min" or "90" (seconds), or in SLURM's format: M:SS, H:MM:SS, D-H, D-HH:MM
/// or D-HH:MM:SS. Returns seconds; empty for other text.
std::optional<double> duration(std::string_view text);

/// When a command suspends samples under way, and how often it writes checkpoints.
struct SuspendOptions {
  std::optional<double> time_limit;       ///< [s]
  double checkpoint_interval = infinity;  ///< [s]
};

/// True if a launcher has started this process as one of several ranks, which share the work of a command or
/// leave it to the first one; MPI need not be started to know.
bool has_other_ranks();

/// Declares --time-limit and --checkpoint-interval.
void add_suspend_options(CLI::App& command, SuspendOptions& options);

/// Detects that SLURM has started this program several times independently instead of as the ranks of one
/// run: srun without the required MPI support.
/// @param is_whole the command computes all samples, so only one of these programs can run
/// @throws std::runtime_error in that case; if each may have its own samples, or if a script or shell has
///   started the program, prints one line on standard error instead
void check_tasks(const parallel::Communicator& world, bool is_whole);

/// Effect of signals; for the end of a command's help.
inline constexpr const char* signals_help =
    "SIGTERM, SIGINT, SIGUSR1: suspend samples under way and stop; a second signal ends the program at once.";

/// For the end of a command's help.
inline constexpr const char* crash_help =
    "128 or more: a rank crashed; complete results are kept, continue with --resume.\n";

/// Words quoted for a shell.
std::string shell_line(std::span<const std::string> words);

/// The command line that continues this one: without --resume, --retry-failed and --overwrite, and with
/// `option` appended. Excludes the launcher.
std::string continuation(const CommandLine& typed, const std::string& option);

/// The exit status of a run.
int exit_status(const ensemble::RunOutcome& outcome);

/// Runs `work`. An AgreedError propagates; any other failure, unknown to the other ranks, which would wait
/// forever, is reported and aborts the whole program with the status internal_failure.
int end_collectively(const parallel::Communicator& world, const std::function<int()>& work);

}  // namespace crackle::apps
