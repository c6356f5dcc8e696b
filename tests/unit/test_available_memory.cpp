// SPDX-License-Identifier: GPL-3.0-or-later
// Memory left by a node and its control groups, from mock trees of /proc and /sys.
#include "ensemble/memory.h"
#include "ensemble/realization_queue.h"
#include "geometry/body.h"
#include "geometry/mother_points.h"
#include "support/temporary_folder.h"

#include <gmock/gmock.h>

#include <cmath>
#include <fstream>

namespace crackle::ensemble {
namespace CRACKLE_TEST_FILE {

using ::testing::HasSubstr;

class Node : public testing::Test {
protected:
  void write(const std::string& name, const std::string& text) const {
    const auto file = folder_.path() / name;
    std::filesystem::create_directories(file.parent_path());
    std::ofstream(file) << text;
  }
  AvailableMemory look() const {
    AvailableMemory found = available_memory(folder_.path());
    std::printf("%.4g MB, %s\n", found.bytes / 1e6, found.limit.c_str());
    return found;
  }
  test::TemporaryFolder folder_;
};

TEST_F(Node, WithoutGroupsWhatTheKernelSays) {
  EXPECT_TRUE(std::isinf(look().bytes));
  EXPECT_NO_THROW(check_available(1e15, "a sample", look()));
  write("proc/meminfo", "MemTotal: 9000000 kB\nMemFree: 1 kB\nMemAvailable:    5000000 kB\n");
  EXPECT_EQ(look().bytes, 5e6 * 1024);
}

TEST_F(Node, VersionTwoCountsEveryGroupAboveAndNoCachedFiles) {
  write("proc/meminfo", "MemAvailable: 5000000 kB\n");
  write("proc/self/cgroup", "0::/slurm/job_7/step_0\n");
  write("sys/fs/cgroup/slurm/job_7/step_0/memory.max", "max\n");
  write("sys/fs/cgroup/slurm/job_7/step_0/memory.current", "1000\n");
  EXPECT_EQ(look().limit, "memory of the node");
  write("sys/fs/cgroup/slurm/job_7/memory.max", "3000000000\n");
  write("sys/fs/cgroup/slurm/job_7/memory.current", "1000000000\n");
  write("sys/fs/cgroup/slurm/job_7/memory.stat", "anon 5\ninactive_file 200000000\n");
  EXPECT_EQ(look().bytes, 2.2e9);
  EXPECT_EQ(look().limit, "control group /slurm/job_7");
}

TEST_F(Node, VersionOneAndContainersThatSeeTheirOwnGroupAsTheRoot) {
  write("proc/meminfo", "MemAvailable: 5000000 kB\n");
  write("proc/self/cgroup", "5:cpu,cpuacct:/x\n4:memory:/docker/abc\n0::/\n");
  write("sys/fs/cgroup/memory/memory.limit_in_bytes", "9223372036854771712\n");
  write("sys/fs/cgroup/memory/memory.usage_in_bytes", "1000000000\n");
  EXPECT_EQ(look().bytes, 5e6 * 1024);
  write("sys/fs/cgroup/memory/memory.limit_in_bytes", "800000000\n");
  EXPECT_EQ(look().bytes, 0) << "more taken than allowed";
  write("sys/fs/cgroup/memory/memory.stat", "inactive_file 1\ntotal_inactive_file 900000000\n");
  EXPECT_EQ(look().bytes, 7e8);
}

TEST_F(Node, RefusalsHaveBothNumbers) {
  write("proc/meminfo", "MemAvailable: 1000000 kB\n");
  try {
    check_available(2.5e9, "3 ranks on here", look());
    FAIL() << "not refused";
  } catch (const std::runtime_error& error) {
    EXPECT_THAT(error.what(),
                HasSubstr("memory: 3 ranks on here need about 2.5 GB, and 1.02 GB are available"));
  }
}

TEST(MemoryDemand, MakingAMeshTakesNoFramesAndNoOtherRanks) {
  input::Study parameters;
  parameters.specimen.size = {0.005, 0.0245, 0.14};
  parameters.mesh.spacing = parameters.mesh.notch_spacing = 0.0005;
  const geometry::Body body = *geometry::make_body(parameters.specimen);
  parameters.output.frames = 100000;
  const double mesh = expected_mesh_memory(parameters, body);
  EXPECT_LT(mesh, 1e-3 * expected_memory_demand(parameters, body, one_group(1)).root);
  // 180 bytes for each of 6 tetrahedra per node.
  EXPECT_NEAR(mesh, 50e6 + 180 * 6 * geometry::estimate_n_points(body, parameters.mesh), 1e3);
}

TEST(MemoryDemand, FollowsTheLayout) {
  input::Study parameters;
  const auto of = [&](int n_ranks, int per_sample) {
    return memory_demand(parameters, 5e6, 27e6, make_group_layout(n_ranks, per_sample));
  };
  EXPECT_GE(of(1, 1).master, of(2, 1).root) << "one rank makes meshes, then computes";
  EXPECT_LT(of(5, 4).member, 0.3 * of(2, 1).member);
  EXPECT_GT(of(5, 4).root, of(5, 4).member);
  EXPECT_LT(of(1001, 1).master, of(2, 1).master + static_cast<double>(most_bytes_ahead))
      << "what is made ahead is bounded";
  EXPECT_LT(memory_demand(parameters, 55e3, 300e3, make_group_layout(1001, 1)).master, 2e9);
  EXPECT_GT(of(65, 64).member * 64, of(2, 1).member) << "ranks repeat what is at the surfaces of their parts";
  parameters.ensemble.meshes = input::MeshMakers::master;
  EXPECT_GT(of(65, 64).root, 180 * 27e6) << "a root divides the mesh";
  parameters.ensemble.meshes = input::MeshMakers::automatic;
  const auto few = of(2, 1).root;
  parameters.output.frames = 100;
  EXPECT_GT(of(2, 1).root, few + 80 * 5e6 * 24) << "displacement and velocity of each frame";
  const auto maker = of(3, 1).master;
  parameters.ensemble.meshes = input::MeshMakers::groups;
  EXPECT_LT(of(3, 1).master, 0.1 * maker) << "a master that makes no meshes";
  parameters.ensemble.meshes = input::MeshMakers::automatic;
  const auto alone = memory_demand(parameters, 5e6, 27e6, one_group(4));
  EXPECT_GT(alone.master, alone.member);
  const auto layout = make_group_layout(1000, 500);
  const auto many = memory_demand(parameters, 5e6, 27e6, layout);
  EXPECT_GT(many.of_rank(layout, 7), 240 * 5e6) << "places mother points";
  EXPECT_EQ(many.of_rank(layout, 8), many.member);
  EXPECT_LT(many.member, 0.2 * many.placing);
  EXPECT_LT(many.of_rank(layout, 999), 100e6) << "idle";
}

}  // namespace CRACKLE_TEST_FILE
}  // namespace crackle::ensemble
