// SPDX-License-Identifier: GPL-3.0-or-later
// A failed allocation on one rank, anywhere in a sample, ends the sample on all ranks of its group. The
// allocations of this program's own code fail one after the other, each in a separate run; those of libraries
// do not.
#include "parallel/agreement.h"

#include "support/box_mesh.h"
#include "support/group.h"
#include "two_pieces.h"

#include <execinfo.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <cstdint>
#include <cstdio>
#include <cstdlib>
#include <new>
#include <set>
#include <string>
#include <thread>
#include <vector>

extern "C" {
void* __libc_malloc(std::size_t size);  // NOLINT: glibc's own name
extern char __executable_start, etext;  // NOLINT: the linker's names
}

namespace {

/// Counts the allocations of the computing thread.
struct Allocations {
  bool counts = false;
  bool records = false;
  std::int64_t n = 0;
  std::int64_t failing = -1;
  void* failed_for = nullptr;        // the code whose allocation failed
  std::vector<std::int64_t> places;  // the first allocation at each place in the code
  std::set<std::uint64_t> known;

  bool fails(void* caller) {
    if (!counts) return false;
    const std::int64_t number = n++;
    if (records) record(number);
    if (number == failing) failed_for = caller;
    return number == failing;
  }

private:
  void record(std::int64_t number) {
    counts = false;
    std::array<void*, 9> frames{};
    const int n_frames = backtrace(frames.data(), static_cast<int>(frames.size()));
    std::uint64_t place = 0;
    for (int i = 2; i < n_frames; ++i)
      place = place * 1099511628211U + reinterpret_cast<std::uintptr_t>(frames[static_cast<std::size_t>(i)]);
    if (known.insert(place).second) places.push_back(number);
    counts = true;
  }
};

thread_local Allocations allocations;

void* allocate(std::size_t size, void* caller) {
  if (allocations.fails(caller)) throw std::bad_alloc();
  void* const memory = __libc_malloc(size);
  if (memory == nullptr) throw std::bad_alloc();
  return memory;
}

}  // namespace

void* operator new(std::size_t size) {
  return allocate(size, __builtin_return_address(0));
}
void* operator new[](std::size_t size) {
  return allocate(size, __builtin_return_address(0));
}
// If inlined next to a new that is not, the compiler would warn.
[[gnu::noinline]] void operator delete(void* memory) noexcept {
  std::free(memory);
}
[[gnu::noinline]] void operator delete[](void* memory) noexcept {
  std::free(memory);
}
[[gnu::noinline]] void operator delete(void* memory, std::size_t) noexcept {
  std::free(memory);
}
[[gnu::noinline]] void operator delete[](void* memory, std::size_t) noexcept {
  std::free(memory);
}

/// For this program's own code only, which is Eigen's: allocation failures inside libraries are not tested.
extern "C" void* malloc(std::size_t size) {
  char* const caller = static_cast<char*>(__builtin_return_address(0));
  if (caller >= &__executable_start && caller < &etext && allocations.fails(caller)) {
    errno = ENOMEM;
    return nullptr;
  }
  return __libc_malloc(size);
}

namespace crackle::dynamics {
namespace {

using input::BoundaryKind;
using plane::Face;

input::Parameters pulled_bar() {
  auto parameters = test::brittle({0.002, 0.004, 0.008});
  parameters.fracture.impulse = 1e5;
  parameters.fracture.release = input::Release::facet;
  parameters.time.duration = 4e-6;
  parameters.time.step = 4e-8;
  parameters.time.arrest = 1.5e-6;
  parameters.boundaries.push_back(test::boundary(Face::z_min, BoundaryKind::fix, {true, true, true}));
  parameters.boundaries.push_back(test::boundary(Face::z_max, BoundaryKind::force, {}, {}, {0, 0, 10}));
  parameters.output.frames = 2;
  return parameters;
}

class FailingAllocation : public testing::TestWithParam<input::Engine> {};

TEST_P(FailingAllocation, EndsTheSampleOnAllRanks) {
  const parallel::Communicator world(test::group());
  if (world.size() > 3) GTEST_SKIP() << "groups of one, two and three ranks are enough";
  auto parameters = pulled_bar();
  parameters.time.engine = GetParam();
  // In one of the two cases, balls that extend into other parts.
  if (GetParam() == input::Engine::petsc) parameters.fracture.length = 1.5e-3;
  const auto mesh =
      test::make_box({.size = parameters.specimen.size, .cells = {2, 3, 6}, .disturbance = 0.2});
  const auto part = geometry::split(mesh, geometry::partition(mesh, world.size()),
                                    parameters.fracture.length)[index(world.rank())];
  void* first = nullptr;
  backtrace(&first, 1);  // allocates on its first call

  // Runs one sample; true if it failed, which must agree on all ranks.
  std::string message;
  const auto run = [&] {
    const parallel::Communicator group(world.get());
    bool failed = false;
    message.clear();
    try {
      SampleControl control;
      control.log = [](const std::string&) {};
      in_two_pieces(group, parameters, parameters.output, part, control);
    } catch (const parallel::AgreedError& error) {
      allocations.counts = false;
      failed = true;
      message = error.what();
    }
    allocations.counts = false;
    int n_failed = failed ? 1 : 0;
    MPI_Allreduce(MPI_IN_PLACE, &n_failed, 1, MPI_INT, MPI_SUM, world.get());
    EXPECT_TRUE(n_failed == 0 || n_failed == world.size()) << n_failed << " ranks have failed";
    return failed;
  };

  allocations = {};
  allocations.records = allocations.counts = true;
  ASSERT_FALSE(run()) << message;
  allocations.records = false;
  // Some places in the code on each rank, most of them on two ranks, unless all are requested.
  const bool is_thorough = std::getenv("CRACKLE_ALL_ALLOCATIONS") != nullptr;
  const std::int64_t n_tried = world.size() == 2 ? 40 : 12;
  int n_runs = 0, n_failed = 0;
  for (int rank = 0; rank < world.size(); ++rank) {
    auto n_places = static_cast<std::int64_t>(allocations.places.size());
    MPI_Bcast(&n_places, 1, MPI_INT64_T, rank, world.get());
    EXPECT_GT(n_places, 100);
    const std::int64_t n_here = is_thorough ? n_places : std::min(n_places, n_tried);
    for (std::int64_t i = 0; i < n_here; ++i) {
      allocations.n = 0;
      allocations.failed_for = nullptr;
      allocations.failing = rank == world.rank() ? allocations.places[index(i * n_places / n_here)] : -1;
      if (is_thorough && rank == world.rank()) {
        std::fprintf(stderr, "rank %d, allocation %lld\n", rank, static_cast<long long>(allocations.failing));
      }
      allocations.counts = true;
      const bool failed = run();
      ++n_runs;
      n_failed += failed ? 1 : 0;
      if (failed) {
        EXPECT_NE(message.find("std::bad_alloc"), std::string::npos) << message;
      }
    }
  }
  allocations.failing = -1;
  EXPECT_FALSE(run()) << message;
  // The other failures only lose a checkpoint or a line of the log.
  EXPECT_GT(n_failed, n_runs / 2);
  if (world.is_root()) std::printf("%d allocations failed, %d of them ended the sample\n", n_runs, n_failed);
}

INSTANTIATE_TEST_SUITE_P(Engines, FailingAllocation,
                         testing::Values(input::Engine::fixed_point, input::Engine::petsc),
                         [](const auto& info) {
                           return info.param == input::Engine::petsc ? "Petsc" : "FixedPoint";
                         });

}  // namespace
}  // namespace crackle::dynamics
