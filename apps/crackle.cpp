// SPDX-License-Identifier: GPL-3.0-or-later
// The program: parse the command line, start MPI and PETSc, run one command, turn failures into exit
// statuses.
#include "commands.h"
#include "crackle/version.h"

#include <fmt/format.h>
#include <petscsys.h>
#include <CLI/CLI.hpp>

#include <cstdio>
#include <exception>

namespace {

/// Starts and ends PETSc, and with it MPI.
class Runtime {
public:
  Runtime() : started_(PetscInitializeNoArguments() == 0) {}
  ~Runtime() {
    if (started_) PetscFinalize();
  }
  Runtime(const Runtime&) = delete;
  Runtime& operator=(const Runtime&) = delete;
  bool started() const { return started_; }

private:
  bool started_;
};

}  // namespace

int main(int argc, char** argv) {
  using namespace crackle;

  CLI::App app{"crackle: Monte-Carlo ensembles of dynamic brittle fracture by PDS-FEM", "crackle"};
  apps::Action run;
  app.require_subcommand(1);
  app.set_version_flag("--version", [] { return version_text(); });
  apps::add_check_command(app, run);
  apps::add_mesh_command(app, run);
  apps::add_sample_command(app, run);
  apps::add_run_command(app, run);
  apps::add_stats_command(app, run);

  Runtime runtime;
  if (!runtime.started()) {
    fmt::print(stderr, "crackle: MPI or PETSc could not be started\n");
    return apps::input_error;
  }
  const parallel::Communicator world(MPI_COMM_WORLD);
  try {
    app.parse(argc, argv);
  } catch (const CLI::ParseError& outcome) {
    // --help and --version arrive here too, with exit code 0.
    const int status = world.is_root() ? app.exit(outcome) : outcome.get_exit_code();
    return status == 0 ? apps::success : apps::input_error;
  }
  try {
    return run(world);
  } catch (const std::exception& error) {
    // Commands throw agreed errors, the same on every rank, so one message is enough.
    if (world.is_root()) fmt::print(stderr, "crackle: {}\n", error.what());
    return apps::input_error;
  }
}
