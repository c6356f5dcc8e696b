// SPDX-License-Identifier: GPL-3.0-or-later
// How many samples per second a run hands out to groups that only pretend to compute: with meshes that the
// master makes, and with meshes that the groups make.
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

#include <cstdio>
#include <numeric>
#include <string>
#include <vector>

namespace {

using namespace crackle;

/// Steps of samples that cost their realization only, or nothing at all.
ensemble::SampleSteps pretended(ensemble::RealizationMaker make) {
  ensemble::SampleSteps steps;
  steps.make = std::move(make);
  steps.split = [](const geometry::Realization&, int n_parts) {
    return std::vector<geometry::Subdomain>(static_cast<std::size_t>(n_parts));
  };
  steps.compute = [](const auto&, auto, const auto&, const auto&) { return dynamics::SampleResult(); };
  steps.analyse = [](const auto&, const auto&) { return ensemble::SampleAnalysis(); };
  steps.write = [](auto, const auto&, const auto&, const auto&) {};
  steps.write_failure = [](auto, const auto&, const auto*) {};
  steps.failure_row = [](const std::string&) { return analysis::SampleSummary(); };
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
    const auto body = geometry::make_body(parameters.specimen);
    const auto base = ensemble::make_shared_points(*body, parameters, {});
    const auto real = pretended(
        [&](std::uint64_t sample) { return ensemble::make_sample_mesh(*body, base, parameters, sample, 0); });
    const auto empty = pretended([](std::uint64_t) { return geometry::Realization(); });
    const auto print = [&](const char* what, double samples_per_second) {
      if (world.is_root()) fmt::print("{:<40} {:10.1f} samples per second\n", what, samples_per_second);
    };
    print("meshes of the input, by the master", rate(world, real, n, input::MeshMakers::master));
    print("meshes of the input, by the groups", rate(world, real, n, input::MeshMakers::groups));
    print("no meshes at all: messages", rate(world, empty, 100 * n, input::MeshMakers::groups));
  } catch (const std::exception& error) {
    std::fprintf(stderr, "benchmark_hand_out: %s\n", error.what());
    status = 1;
  }
  PetscFinalize();
  return status;
}
