// SPDX-License-Identifier: GPL-3.0-or-later
// Samples per second handed out by a run to groups that only pretend to compute, with meshes made by the
// master and with meshes made by the groups; and the rate per group extrapolated to 1,000 groups, where each
// rank represents 250: it sleeps for 1/250 of a sample and pretends to make its mesh too.
//
//   mpirun -n 5 benchmark_hand_out INPUT [N]
#include "common/stopwatch.h"
#include "ensemble/base_points.h"
#include "ensemble/sample_schedule.h"
#include "input/reader.h"
#include "parallel/sleeping_wait.h"

#include "run_benchmark.h"

#include <fmt/format.h>
#include <mpi.h>

#include <chrono>
#include <memory>
#include <numeric>
#include <string>
#include <thread>
#include <utility>
#include <vector>

namespace {

using namespace crackle;

constexpr double groups_per_rank = 250;
constexpr double sample_seconds = 13;  // for jobs/paper/clock-from-zero.toml with `verlet` and `auto`

/// Steps that sleep for some seconds in place of the computation.
class PretendedSteps final : public ensemble::SampleSteps {
public:
  explicit PretendedSteps(double seconds) : seconds_(seconds) {}

  std::vector<geometry::Subdomain> split(const geometry::Realization&, int n_parts) override {
    return std::vector<geometry::Subdomain>(static_cast<std::size_t>(n_parts));
  }
  dynamics::SampleResult compute(const parallel::Communicator&, const geometry::Subdomain&,
                                 dynamics::SampleControl) override {
    std::this_thread::sleep_for(std::chrono::duration<double>(seconds_));
    return {};
  }
  ensemble::SampleAnalysis analyse(const geometry::Realization&, const dynamics::SampleResult&) override {
    return {};
  }
  void write(const geometry::Realization&, const dynamics::SampleResult&,
             const ensemble::SampleAnalysis&) override {}
  void write_failure(const analysis::SampleSummary&, const ensemble::PartialSample*) override {}
  analysis::SampleSummary failure_row(const std::string&) override { return {}; }

private:
  double seconds_;
};

/// Samples that make their realization and then only sleep.
class PretendedSamples final : public ensemble::SampleSource {
public:
  PretendedSamples(ensemble::RealizationMaker make, double seconds)
      : make_(std::move(make)), seconds_(seconds) {}

  geometry::Realization make(std::uint64_t sample) override { return make_(sample); }
  std::unique_ptr<ensemble::SampleSteps> steps(std::uint64_t) override {
    return std::make_unique<PretendedSteps>(seconds_);
  }

private:
  ensemble::RealizationMaker make_;
  double seconds_;
};

class NoEvents final : public ensemble::ScheduleEvents {
  void started(std::uint64_t) override {}
  void finished(const ensemble::SampleReport&) override {}
};

double rate(const parallel::Communicator& world, PretendedSamples source, std::uint64_t n,
            input::MeshMakers makers) {
  std::vector<std::uint64_t> samples(n);
  std::iota(samples.begin(), samples.end(), 0);
  NoEvents events;
  const auto layout = ensemble::make_group_layout(world.size(), 1);
  parallel::barrier_asleep(world);
  const Stopwatch watch;
  ensemble::schedule_samples(world, layout, samples, source, events,
                             {.n_realizations = static_cast<std::size_t>(world.size())}, makers);
  return static_cast<double>(n) / watch.seconds();
}

}  // namespace

int main(int argc, char** argv) {
  return run_benchmark("benchmark_hand_out", [&] {
    const parallel::Communicator world(MPI_COMM_WORLD);
    const auto parameters = input::read(argc > 1 ? argv[1] : "jobs/paper/clock-from-zero.toml");
    const auto n = static_cast<std::uint64_t>(argc > 2 ? std::stoi(argv[2]) : 40);
    const auto body = geometry::make_body(parameters);
    const auto base = ensemble::make_shared_points(*body, parameters.mesh, parameters.seed, {});
    const auto make = [&](std::uint64_t sample) {
      return ensemble::make_sample_mesh(*body, base, parameters.mesh, parameters.seed, sample, 0);
    };
    const auto make_nothing = [](std::uint64_t) { return geometry::Realization(); };
    const auto print = [&](const std::string& what, double samples_per_second) {
      if (world.is_root()) fmt::print("{:<52} {:10.1f} samples per second\n", what, samples_per_second);
    };
    using input::MeshMakers;
    const PretendedSamples meshes(make, 0);
    print("meshes of the input, by the master", rate(world, meshes, n, MeshMakers::master));
    print("meshes of the input, by the groups", rate(world, meshes, n, MeshMakers::groups));
    print("no meshes at all: messages",
          rate(world, PretendedSamples(make_nothing, 0), 100 * n, MeshMakers::groups));
    const double n_groups = groups_per_rank * (world.size() - 1);
    const double pause = sample_seconds / groups_per_rank;
    const std::string many = fmt::format("{:.0f} groups, ", n_groups);
    print(fmt::format("{}samples of {:.0f} s, at most", many, sample_seconds), n_groups / sample_seconds);
    print(many + "meshes by the master", rate(world, PretendedSamples(make, pause), n, MeshMakers::master));
    print(many + "meshes by the groups",
          rate(world, PretendedSamples(make_nothing, pause), 10 * n, MeshMakers::groups));
  });
}
