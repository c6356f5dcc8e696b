// SPDX-License-Identifier: GPL-3.0-or-later
// What the ranks that share a sample exchange, and their time steps, as JSON.
//
//   benchmark_scaling INPUT PARTS...                      the parts of the mesh in these numbers
//   mpirun -n P benchmark_scaling INPUT [--seconds S]     steps on P ranks, and messages between two of them
//
// Steps are those of the intact body under a sudden load. Processor time without that of MPI, its median over
// rounds, matters little to what else the machine does; of exchanges, the least in rounds so short that other
// programs may leave some of them alone.
#include "common/stopwatch.h"
#include "dynamics/breaking_check.h"
#include "dynamics/moving_body.h"
#include "dynamics/stable_step.h"
#include "ensemble/base_points.h"
#include "ensemble/scaling.h"
#include "fracture/fracture_law.h"
#include "fracture/material_field.h"
#include "geometry/body.h"
#include "geometry/partition.h"
#include "input/reader.h"
#include "mechanics/conditions.h"
#include "parallel/petsc.h"

#include "run_benchmark.h"

#include <fmt/format.h>
#include <mpi.h>

#include <algorithm>
#include <array>
#include <cstdio>
#include <string>
#include <vector>

namespace {

double seconds_in_mpi = 0;  // processor time of the calls below

template <class Call>
int timed(const Call& call) {
  const crackle::ThreadClock clock;
  const int status = call();
  seconds_in_mpi += clock.seconds();
  return status;
}

}  // namespace

// The calls of an exchange, through the interface for profilers; in brackets, since PETSc has macros of these
// names.
extern "C" int(MPI_Startall)(int n, MPI_Request* requests) {
  return timed([&] { return PMPI_Startall(n, requests); });
}
extern "C" int(MPI_Waitall)(int n, MPI_Request* requests, MPI_Status* statuses) {
  return timed([&] { return PMPI_Waitall(n, requests, statuses); });
}

namespace {

using namespace crackle;

constexpr double load_time = 1;  // [s]
constexpr double round_seconds = 0.02;

geometry::Realization make_mesh(const input::Parameters& parameters) {
  const auto body = geometry::make_body(parameters);
  const auto base = parameters.mesh.base == input::Base::shared
                        ? ensemble::make_base_points(*body, parameters.mesh, parameters.seed)
                        : geometry::MotherPoints{};
  return ensemble::make_sample_realization(*body, base, parameters, 0);
}

void print_parts(const geometry::Realization& mesh, const std::vector<int>& numbers) {
  fmt::print("{{\"tetrahedra\": {}, \"nodes\": {}, \"parts\": [", mesh.tetrahedra.size(), mesh.nodes.size());
  for (const int n : numbers) {
    const auto part = ensemble::largest_part(mesh, n);
    fmt::print(
        "{}{{\"parts\": {}, \"tetrahedra\": {}, \"ghosts\": {}, \"neighbours\": {}, \"seconds\": {:.3g}}}",
        n == numbers.front() ? "" : ", ", n, part.tetrahedra, part.ghosts, part.neighbours, part.seconds);
    std::fflush(stdout);
  }
  fmt::print("]}}\n");
}

/// Half of the time in which a message of so many bytes goes to the other rank and back, the least of many
/// [s].
double message_seconds(int rank, int n_bytes) {
  std::vector<char> bytes(static_cast<std::size_t>(n_bytes));
  double least = infinity;
  for (int i = 0; i < 2000; ++i) {
    const Stopwatch watch;
    for (const int from : {0, 1}) {
      if (rank == from)
        MPI_Send(bytes.data(), n_bytes, MPI_CHAR, 1 - from, 0, MPI_COMM_WORLD);
      else if (rank == 1 - from)
        MPI_Recv(bytes.data(), n_bytes, MPI_CHAR, from, 0, MPI_COMM_WORLD, MPI_STATUS_IGNORE);
    }
    least = std::min(least, watch.seconds() / 2);
  }
  return least;
}

/// The time loop on all ranks.
void measure_steps(const parallel::Communicator& world, const input::Parameters& parameters,
                   const geometry::Realization& mesh, double seconds) {
  const auto part = geometry::split(mesh, geometry::partition(mesh, world.size()))[index(world.rank())];
  fracture::BreakableBody body(part, fracture::make_material_field(parameters, 0, fracture::span_of(part)));
  const auto loads = mechanics::make_boundary_loads(world, parameters, part);
  const double stable = dynamics::stable_step(parameters, mesh).step;
  const auto grid = dynamics::choose_time_grid(parameters.time, stable);
  fracture::FractureLaw law(world, parameters, 0, body, {grid.step, stable}, {.follows_cracks = false});
  dynamics::MotionState state{parallel::NodeField(world, part.layout),
                              parallel::NodeField(world, part.layout)};
  const dynamics::MotionContext context{&world, &body, &loads, &law};
  const auto motion =
      dynamics::make_fixed_point_motion(context, parameters.time.precision, load_time, 1e-4, state);
  const auto breaking = dynamics::make_breaking_check(context, *motion);
  breaking->start();
  const auto& splitting = dynamics::splitting(parameters.time.integrator);

  int n = 0;
  // Seconds of a step: processor time without MPI, that of the breaking check, beginning and awaiting
  // exchanges.
  const auto run = [&](int n_steps) {
    const double exchanged = motion->exchange_cost().seconds;
    std::array<double, 3> seconds{};
    MPI_Barrier(world.get());
    const double in_mpi = seconds_in_mpi;
    const ThreadClock all;
    for (int i = 0; i < n_steps; ++i, ++n) {
      motion->step(n % 2 == 0 ? splitting.even : splitting.odd, grid.step, load_time);
      const ThreadClock check;
      breaking->end_step(n + 1);
      seconds[1] += check.seconds();
    }
    seconds[0] = all.seconds() - (seconds_in_mpi - in_mpi);
    seconds[2] = motion->exchange_cost().seconds - exchanged;
    for (double& one : seconds) one /= n_steps;
    MPI_Allreduce(MPI_IN_PLACE, seconds.data(), 3, MPI_DOUBLE, MPI_MAX, world.get());
    return seconds;
  };
  run(2);  // touches memory
  const double of_two = 2 * run(2)[0];
  const int n_steps = 2 * std::max(1, static_cast<int>(round_seconds / of_two));
  const int n_rounds = std::max(9, static_cast<int>(seconds / std::max(round_seconds, of_two)));
  std::array<std::vector<double>, 3> rounds;
  for (int round = 0; round < n_rounds; ++round) {
    const auto found = run(n_steps);
    for (std::size_t i = 0; i < 3; ++i) rounds.at(i).push_back(found.at(i));
  }
  for (auto& one : rounds) std::ranges::sort(one);
  const auto middle = static_cast<std::size_t>(n_rounds / 2);
  const double latency = world.size() == 2 ? message_seconds(world.rank(), 8) : 0;
  constexpr int large = 1 << 17;
  const double of_large = world.size() == 2 ? message_seconds(world.rank(), large) : 0;
  const auto cost = motion->exchange_cost();
  if (world.rank() != 0) return;
  fmt::print(
      "{{\"ranks\": {}, \"tetrahedra\": {}, \"step\": {:.6g}, \"check\": {:.6g}, \"exchange\": {:.6g}, "
      "\"bytes\": {}, \"latency\": {:.3g}, \"bandwidth\": {:.3g}}}\n",
      world.size(), mesh.tetrahedra.size(), rounds[0][middle], rounds[1][middle], rounds[2].front(),
      cost.bytes_per_exchange, latency, of_large > 0 ? large / of_large : 0);
}

}  // namespace

int main(int argc, char** argv) {
  return run_benchmark("benchmark_scaling", [&] {
    const parallel::Communicator world(MPI_COMM_WORLD);
    const auto parameters = input::read(argv[1]);
    std::vector<int> numbers;
    double seconds = 20;
    for (int i = 2; i < argc; ++i)
      if (std::string(argv[i]) == "--seconds")
        seconds = std::stod(argv[++i]);
      else
        numbers.push_back(std::stoi(argv[i]));
    const auto mesh = make_mesh(parameters);
    if (numbers.empty())
      measure_steps(world, parameters, mesh, seconds);
    else
      print_parts(mesh, numbers);
  });
}
