// SPDX-License-Identifier: GPL-3.0-or-later
// Samples per second handed out by a run to groups that only pretend to compute, with meshes made by the
// master and with meshes made by the groups; and the rate per group extrapolated to 1,000 groups, where each
// rank represents 250: it sleeps for 1/250 of a sample and pretends to make its mesh too.
//
//   mpirun -n 5 benchmark_hand_out INPUT [N]
#include "crackle/common/stopwatch.h"
#include "crackle/ensemble/base_points.h"
#include "crackle/ensemble/sample_schedule.h"
#include "crackle/input/reader.h"
#include "crackle/parallel/sleeping_wait.h"

#include <fmt/format.h>
#include <mpi.h>
#include <petscsys.h>

#include <chrono>
#include <cstdio>
#include <numeric>
#include <string>
#include <thread>
#include <vector>

namespace {

using namespace crackle;

constexpr double groups_per_rank = 250;
constexpr double sample_seconds = 13;  // for jobs/paper/clock-from-zero.toml with `verlet` and `auto`

/// Steps of mock samples that make their realization and then sleep for some seconds.
ensemble::SampleSteps pretended(ensemble::RealizationMaker make, double seconds) {
  ensemble::SampleSteps steps;
  steps.make = std::move(make);
  steps.split = [](std::uint64_t, const geometry::Realization&, int n_parts) {
    return std::vector<geometry::Subdomain>(static_cast<std::size_t>(n_parts));
  };
  steps.compute = [seconds](const auto&, auto, const auto&, const auto&) {
    std::this_thread::sleep_for(std::chrono::duration<double>(seconds));
    return dynamics::SampleResult();
  };
  steps.analyse = [](auto, const auto&, const auto&) { return ensemble::SampleAnalysis(); };
  steps.write = [](auto, const auto&, const auto&, const auto&) {};
  steps.write_failure = [](auto, const auto&, const auto*) {};
  steps.failure_row = [](auto, const std::string&) { return analysis::SampleSummary(); };
  return steps;
}

double rate(const parallel::Communicator& world, const ensemble::SampleSteps& steps, std::uint64_t n,
            input::MeshMakers makers) {
  std::vector<std::uint64_t> samples(n);
  std::iota(samples.begin(), samples.end(), 0);
  ensemble::ScheduleEvents events;
  events.started = [](std::uint64_t) {};
  events.finished = [](const ensemble::SampleReport&) {};
  events.tick = [] {};
  const auto layout = ensemble::make_group_layout(world.size(), 1);
  parallel::barrier_asleep(world);
  const Stopwatch watch;
  ensemble::schedule_samples(world, layout, samples, steps, events,
                             {.n_realizations = static_cast<std::size_t>(world.size())}, makers);
  return static_cast<double>(n) / watch.seconds();
}

}  // namespace

int main(int argc, char** argv) {
  PetscInitialize(nullptr, nullptr, nullptr, nullptr);
  int status = 0;
  try {
    const parallel::Communicator world(MPI_COMM_WORLD);
    const auto parameters = input::read(argc > 1 ? argv[1] : "jobs/paper/clock-from-zero.toml");
    const auto n = static_cast<std::uint64_t>(argc > 2 ? std::stoi(argv[2]) : 40);
    const auto body = geometry::make_body(parameters);
    const auto base = ensemble::make_shared_points(*body, parameters, {});
    const auto make = [&](std::uint64_t sample) {
      return ensemble::make_sample_mesh(*body, base, parameters, sample, 0);
    };
    const auto make_nothing = [](std::uint64_t) { return geometry::Realization(); };
    const auto print = [&](const std::string& what, double samples_per_second) {
      if (world.is_root()) fmt::print("{:<52} {:10.1f} samples per second\n", what, samples_per_second);
    };
    using input::MeshMakers;
    const auto meshes = pretended(make, 0);
    print("meshes of the input, by the master", rate(world, meshes, n, MeshMakers::master));
    print("meshes of the input, by the groups", rate(world, meshes, n, MeshMakers::groups));
    print("no meshes at all: messages", rate(world, pretended(make_nothing, 0), 100 * n, MeshMakers::groups));
    const double n_groups = groups_per_rank * (world.size() - 1);
    const double pause = sample_seconds / groups_per_rank;
    const std::string many = fmt::format("{:.0f} groups, ", n_groups);
    print(fmt::format("{}samples of {:.0f} s, at most", many, sample_seconds), n_groups / sample_seconds);
    print(many + "meshes by the master", rate(world, pretended(make, pause), n, MeshMakers::master));
    print(many + "meshes by the groups",
          rate(world, pretended(make_nothing, pause), 10 * n, MeshMakers::groups));
  } catch (const std::exception& error) {
    std::fprintf(stderr, "benchmark_hand_out: %s\n", error.what());
    status = 1;
  }
  PetscFinalize();
  return status;
}
