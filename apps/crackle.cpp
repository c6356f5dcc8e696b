// SPDX-License-Identifier: GPL-3.0-or-later
// Parse the command line, run one command, turn failures into exit statuses.
#include "crackle.h"

#include "common/nearest_name.h"
#include "common/printable.h"
#include "input/reader.h"
#include "io/sample_file.h"
#include "parallel/agreement.h"
#include "parallel_command.h"
#include "version.h"

#include <fmt/format.h>
#include <CLI/CLI.hpp>

#include <algorithm>
#include <cstdio>
#include <exception>
#include <functional>
#include <sstream>
#include <stdexcept>
#include <string>
#include <vector>

namespace crackle::apps {

namespace {

void add_commands(CLI::App& app, const CommandLine& typed, const std::function<void()>& start_mpi,
                  Action& run) {
  app.require_subcommand(0, 1);
  app.set_version_flag("--version", [] {
    return fmt::format("crackle {}\ngit commit {}\n{}\nresults of model {}, files of schema {}",
                       program_version(), git_commit(), library_versions(), io::model_version,
                       io::sample_schema_version);
  });
  add_init_command(app, typed, run);
  add_check_command(app, start_mpi, run);
  add_mesh_command(app, run);
  add_sample_command(app, typed, run);
  add_run_command(app, typed, run);
  add_watch_command(app, run);
  add_stats_command(app, run);
  add_compare_command(app, typed, run);
  add_observe_command(app, run);
  add_match_command(app, typed, run);
  add_calibrate_command(app, typed, run);
}

/// "crackle run" when that command was named on the command line.
std::string chosen_command(const CLI::App& app) {
  std::string name = app.get_name();
  for (const CLI::App* command : app.get_subcommands()) name += " " + command->get_name();
  return name;
}

/// The fault of the command line. CLI11 names every argument after an unknown command.
std::string complaint(const CLI::App& app, const CLI::ParseError& error, const std::string& command) {
  std::vector<std::string> known;
  for (const CLI::App* one : app.get_subcommands([](const CLI::App*) { return true; }))
    known.push_back(one->get_name());
  const bool is_known = std::ranges::find(known, command) != known.end();
  if (command.empty() || command.starts_with('-') || is_known) return printable(error.what());
  const auto nearest = nearest_name(command, known);
  return printable(fmt::format("there is no command \"{}\"{}", command,
                               nearest ? fmt::format(" (did you mean {}?)", *nearest) : ""));
}

/// The action that the command line asks for; of a wrong one, of --help and of --version, to print what there
/// is to say.
Action parse(CLI::App& app, const CommandLine& words, const Action& chosen) {
  const auto print_and_end = [](FILE* stream, const std::string& text, int status) {
    return Action{[=](const parallel::Communicator& world) {
      if (world.is_root()) fmt::print(stream, "{}", text);
      return status;
    }};
  };
  if (words.size() <= 1) return print_and_end(stdout, app.help(), input_error);
  try {
    app.parse(std::vector(words.rbegin(), words.rend() - 1));  // CLI11 takes them from the last to the first
    if (app.get_subcommands().empty()) throw CLI::RequiredError("a command");
    return chosen;
  } catch (const CLI::ParseError& outcome) {
    // --help and --version also arrive here, with exit code 0.
    if (outcome.get_exit_code() == 0) {
      std::ostringstream text;
      app.exit(outcome, text, text);
      return print_and_end(stdout, text.str(), success);
    }
    return print_and_end(
        stderr,
        fmt::format("crackle: {}; see {} --help\n", complaint(app, outcome, words[1]), chosen_command(app)),
        input_error);
  }
}

int run_command(const Action& run, const parallel::Communicator& world) {
  try {
    return run.work(world);
  } catch (const input::InputError& error) {
    // Its lines start with the file name.
    if (world.is_root()) fmt::print(stderr, "{}\n", printable(error.what()));
  } catch (const parallel::AgreedError& error) {
    if (world.is_root()) fmt::print(stderr, "crackle: {}\n", printable(error.what()));
  } catch (const std::exception& error) {
    if (world.size() == 1) {
      fmt::print(stderr, "crackle: {}\n", printable(reason_of(error)));
    } else {
      // The other ranks may not know of this failure and would wait forever.
      fmt::print(stderr, "crackle: rank {}: {}\n", world.rank(), printable(reason_of(error)));
      std::fflush(nullptr);
      MPI_Abort(world.get(), internal_failure);
    }
  }
  return input_error;
}

}  // namespace

int crackle(MPI_Comm ranks, const CommandLine& words, const std::function<void()>& start_mpi) {
  CLI::App app{"crackle: Monte-Carlo ensembles of dynamic brittle fracture by PDS-FEM", "crackle"};
  Action chosen;
  add_commands(app, words, start_mpi, chosen);
  const Action run = parse(app, words, chosen);
  try {
    if (run.needs_mpi || has_other_ranks()) start_mpi();
  } catch (const std::runtime_error& error) {
    fmt::print(stderr, "crackle: {}\n", error.what());
    return input_error;
  }
  const parallel::Communicator world(ranks);
  int status = run_command(run, world);
  if (world.is_root() && (std::fflush(stdout) != 0 || std::ferror(stdout) != 0) && status == success) {
    fmt::print(stderr, "crackle: standard output cannot be written\n");
    status = input_error;
  }
  return status;
}

}  // namespace crackle::apps
