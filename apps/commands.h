// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "common/text_table.h"
#include "geometry/body.h"
#include "geometry/realization.h"
#include "input/reader.h"
#include "parallel/communicator.h"

#include <cstdint>
#include <filesystem>
#include <functional>
#include <string>
#include <vector>

namespace CLI {
class App;
class Option;
}  // namespace CLI

/// The commands of the program. Each function declares its command on `app`; if the command is given on the
/// command line, `run` is set to its action.
namespace crackle::apps {

/// The work of a command; returns the exit status.
struct Action {
  std::function<int(const parallel::Communicator& world)> work;
  bool needs_mpi = false;  ///< from its beginning on
};

/// Exit statuses of the program.
enum ExitStatus : int {
  success = 0,
  input_error = 1,
  some_samples_failed = 2,
  stopped_resumable = 3,
  internal_failure = 134  ///< status shown by a shell for a program that aborts: counts as a crash
};

/// The command line as typed, starting with the program's name.
using CommandLine = std::vector<std::string>;

void add_init_command(CLI::App& app, const CommandLine& typed, Action& run);
/// @param start_mpi is called before the first sample is tried
void add_check_command(CLI::App& app, const std::function<void()>& start_mpi, Action& run);
void add_mesh_command(CLI::App& app, Action& run);
void add_sample_command(CLI::App& app, const CommandLine& typed, Action& run);
void add_run_command(CLI::App& app, const CommandLine& typed, Action& run);
void add_stats_command(CLI::App& app, Action& run);
void add_watch_command(CLI::App& app, Action& run);
void add_compare_command(CLI::App& app, const CommandLine& typed, Action& run);
void add_observe_command(CLI::App& app, Action& run);
void add_match_command(CLI::App& app, const CommandLine& typed, Action& run);
void add_calibrate_command(CLI::App& app, const CommandLine& typed, Action& run);

/// Declares the option --sample, the number of a sample.
CLI::Option* add_sample_option(CLI::App& command, std::uint64_t& sample);

/// @throws std::runtime_error when there is something by that name
void refuse_existing(const std::filesystem::path& file);

/// Prints a line of progress on standard error.
void notify(const std::string& line);

/// The result of `read` on the root, shared with every rank; only the root needs the files. Collective over
/// `world`.
/// @param name of the input in messages
/// @throws the same parallel::AgreedError on every rank
input::Parameters share_input(const parallel::Communicator& world, const std::filesystem::path& name,
                              const std::function<input::Parameters()>& read);

/// Reads the input file on the root, as input::read: either every rank has its parameters or all throw the
/// same input::InputError. Collective over `world`.
input::Parameters read_input(const parallel::Communicator& world, const std::filesystem::path& file,
                             const input::GivenFiles& files = {});

/// As read_input(), for the file that a command is given: its notes are printed on standard error.
input::Parameters read_given_input(const parallel::Communicator& world, const std::filesystem::path& file);

/// The cases of a sweep, as input::sweep_cases: either every rank has them or all throw the same
/// input::InputError. Collective over `world`.
std::vector<input::Case> read_cases(const parallel::Communicator& world, const input::Parameters& parameters,
                                    const std::filesystem::path& file, bool are_stored = false);

/// Rejects an input with [[sweep]], which has no samples of its own.
/// @throws input::InputError
void refuse_sweep(const input::Parameters& parameters, const std::filesystem::path& file);

/// input::with_sections for the option --sections: either every rank has the parameters or all throw the same
/// input::InputError. Collective over `world`.
input::Parameters read_sections(const parallel::Communicator& world, const input::Parameters& parameters,
                                const std::vector<std::string>& given);

/// The named faces of a solid, so that people find which is which; none of a plate.
std::vector<NamedValue> face_rows(const plane::Specimen& specimen);

/// The tetrahedra of each material, as rows of a table; none if the body has only one.
std::vector<NamedValue> material_rows(const input::Parameters& parameters,
                                      const geometry::Realization& realization);

}  // namespace crackle::apps
