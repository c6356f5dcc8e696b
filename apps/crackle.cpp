// SPDX-License-Identifier: GPL-3.0-or-later
// The program: parse the command line, start MPI and PETSc where they are needed, run one command, turn
// failures into exit statuses.
#include "commands.h"
#include "crackle/common/nearest_name.h"
#include "crackle/common/printable.h"
#include "crackle/ensemble/stop_request.h"
#include "crackle/input/reader.h"
#include "crackle/parallel/agreement.h"
#include "crackle/version.h"
#include "parallel_command.h"

#include <fmt/format.h>
#include <petscsys.h>
#include <CLI/CLI.hpp>

#include <algorithm>
#include <array>
#include <csignal>
#include <cstdio>
#include <cstdlib>
#include <exception>
#include <functional>
#include <optional>
#include <sstream>
#include <stdexcept>
#include <string>
#include <string_view>
#include <vector>

namespace {

using namespace crackle;

/// Initializes and finalizes PETSc, and with it MPI.
class Runtime {
public:
  /// @throws std::runtime_error
  Runtime() {
    if (!start()) throw std::runtime_error("MPI or PETSc could not be started");
  }
  ~Runtime() { PetscFinalize(); }
  Runtime(const Runtime&) = delete;
  Runtime& operator=(const Runtime&) = delete;

private:
  bool start() {
    // A stray .petscrc or options in the environment must not change results; signals are handled by the
    // program itself; errors are returned as codes, which callers turn into a single message.
    ::unsetenv("PETSC_OPTIONS");
    ::unsetenv("PETSC_OPTIONS_YAML");
    return PetscInitialize(&n_arguments_, &arguments_, nullptr, nullptr) == 0 &&
           PetscPopSignalHandler() == 0 && PetscPushErrorHandler(PetscReturnErrorHandler, nullptr) == 0;
  }

  // PETSc keeps pointers to these; it must not see the program's own arguments.
  std::string name_ = "crackle";
  std::string skip_option_ = "-skip_petscrc";
  std::array<char*, 3> argument_list_{name_.data(), skip_option_.data(), nullptr};
  char** arguments_ = argument_list_.data();
  int n_arguments_ = 2;
};

void add_commands(CLI::App& app, const apps::CommandLine& typed, const std::function<void()>& start_mpi,
                  apps::Action& run) {
  app.require_subcommand(0, 1);
  app.set_version_flag("--version", [] { return version_text(); });
  apps::add_init_command(app, run);
  apps::add_check_command(app, start_mpi, run);
  apps::add_mesh_command(app, run);
  apps::add_sample_command(app, typed, run);
  apps::add_run_command(app, typed, run);
  apps::add_watch_command(app, run);
  apps::add_stats_command(app, run);
  apps::add_compare_command(app, run);
  apps::add_match_command(app, run);
  apps::add_calibrate_command(app, run);
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
apps::Action parse(CLI::App& app, int argc, char** argv, const apps::Action& chosen) {
  const auto print_and_end = [](FILE* stream, const std::string& text, int status) {
    return apps::Action{[=](const parallel::Communicator& world) {
      if (world.is_root()) fmt::print(stream, "{}", text);
      return status;
    }};
  };
  if (argc <= 1) return print_and_end(stdout, app.help(), apps::input_error);
  try {
    app.parse(argc, argv);
    if (app.get_subcommands().empty()) throw CLI::RequiredError("a command");
    return chosen;
  } catch (const CLI::ParseError& outcome) {
    // --help and --version also arrive here, with exit code 0.
    if (outcome.get_exit_code() == 0) {
      std::ostringstream text;
      app.exit(outcome, text, text);
      return print_and_end(stdout, text.str(), apps::success);
    }
    return print_and_end(
        stderr,
        fmt::format("crackle: {}; see {} --help\n", complaint(app, outcome, argv[1]), chosen_command(app)),
        apps::input_error);
  }
}

int run_command(const apps::Action& run, const parallel::Communicator& world) {
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
      MPI_Abort(world.get(), apps::internal_failure);
    }
  }
  return apps::input_error;
}

}  // namespace

int main(int argc, char** argv) {
  // Exceeding a file size limit becomes a write error, like a full disk.
  std::signal(SIGXFSZ, SIG_IGN);
  // From the start, since the launcher forwards signals as soon as the ranks exist.
  const std::string_view command = argc > 1 ? argv[1] : "";
  const bool can_suspend = command == "run" || command == "sample";
  if (can_suspend) ensemble::watch_stop_signals();
  CLI::App app{"crackle: Monte-Carlo ensembles of dynamic brittle fracture by PDS-FEM", "crackle"};
  std::optional<Runtime> runtime;
  const auto start_mpi = [&runtime] {
    if (!runtime) runtime.emplace();
  };
  apps::Action chosen;
  const apps::CommandLine typed(argv, argv + argc);
  add_commands(app, typed, start_mpi, chosen);
  const apps::Action run = parse(app, argc, argv, chosen);
  try {
    if (run.needs_mpi || apps::has_other_ranks()) start_mpi();
  } catch (const std::runtime_error& error) {
    fmt::print(stderr, "crackle: {}\n", error.what());
    return apps::input_error;
  }
  if (can_suspend) ensemble::watch_stop_signals();  // MPI has installed its own handlers
  const parallel::Communicator world(MPI_COMM_WORLD);
  int status = run_command(run, world);
  if (world.is_root() && (std::fflush(stdout) != 0 || std::ferror(stdout) != 0) && status == apps::success) {
    fmt::print(stderr, "crackle: standard output cannot be written\n");
    status = apps::input_error;
  }
  return status;
}
