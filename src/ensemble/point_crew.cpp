// SPDX-License-Identifier: GPL-3.0-or-later
#include "ensemble/point_crew.h"

#include "parallel/agreement.h"
#include "parallel/collectives.h"

#include <optional>
#include <string>
#include <utility>

namespace crackle::ensemble {

namespace {

/// From the root to the others: points are to be placed, or the work has ended.
struct Call {
  PointTask task;
  bool is_end = false;
};

}  // namespace

void PointCrew::agree_on_root(
    const std::function<void()>& work,
    const std::function<void(const PointTask&, std::vector<input::MeshRegion>)>& help) {
  std::optional<std::string> error;
  try {
    if (places_) work_or_help(work, help);
  } catch (...) {
    error = parallel::current_error();
  }
  parallel::barrier_asleep(world_);
  parallel::agree_on_error(world_, error);
}

/// Collective over the ranks that place points, which all throw the same AgreedError or none.
void PointCrew::work_or_help(
    const std::function<void()>& work,
    const std::function<void(const PointTask&, std::vector<input::MeshRegion>)>& help) {
  std::optional<std::string> error;
  if (group().is_root()) {
    try {
      work();
    } catch (...) {
      error = parallel::current_error();
    }
  }
  for (;;) {
    parallel::barrier_asleep(group());
    parallel::agree_on_error(group(), error);
    const Call call = parallel::share(group(), Call{{}, true});
    if (call.is_end) return;
    auto regions = parallel::share(group(), std::vector<input::MeshRegion>());
    try {
      parallel::run_collectively(group(), [&] { help(call.task, std::move(regions)); });
    } catch (const parallel::AgreedError&) {
      // The root has the same error.
    }
  }
}

geometry::Crew* PointCrew::for_task(const PointTask& task) {
  task_ = task;
  return group().size() > 1 ? this : nullptr;
}

void PointCrew::run(const std::vector<input::MeshRegion>& regions, const std::function<void()>& work) {
  parallel::barrier_asleep(group());
  parallel::check_peers(group());
  parallel::share(group(), Call{task_, false});
  parallel::share(group(), regions);
  parallel::run_collectively(group(), work);
}

void PointCrew::share(std::span<double> values, std::span<const std::size_t> first) {
  struct Parts {
    std::vector<int> counts, offsets;
  };
  const Parts parts = parallel::agree(group(), [&] {
    Parts made;
    for (std::size_t rank = 0; rank < size(); ++rank) {
      made.counts.push_back(static_cast<int>(first[rank + 1] - first[rank]));
      made.offsets.push_back(static_cast<int>(first[rank]));
    }
    return made;
  });
  parallel::check_mpi(MPI_Allgatherv(MPI_IN_PLACE, 0, MPI_DATATYPE_NULL, values.data(), parts.counts.data(),
                                     parts.offsets.data(), MPI_DOUBLE, group().get()),
                      "MPI_Allgatherv");
}

std::vector<std::array<std::int32_t, 2>> PointCrew::gather(
    std::span<const std::array<std::int32_t, 2>> mine) {
  return parallel::gather_all(group(), mine);
}

}  // namespace crackle::ensemble
