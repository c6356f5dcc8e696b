// SPDX-License-Identifier: GPL-3.0-or-later
#include "ensemble/memory.h"

#include "common/real.h"
#include "ensemble/point_crew.h"
#include "ensemble/realization_queue.h"
#include "ensemble/scaling.h"
#include "geometry/mother_points.h"
#include "io/raster.h"
#include "parallel/agreement.h"
#include "parallel/collectives.h"

#include <fmt/format.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <fstream>
#include <sstream>
#include <stdexcept>

namespace crackle::ensemble {

namespace fs = std::filesystem;

namespace {

// From the peak resident set on bodies of 24,000 to 10 million tetrahedra (tests/cli/test_memory.py) [byte].
constexpr double libraries = 50e6;    // and the program, per rank
constexpr double computed = 393;      // per tetrahedron computed by a rank: operators, solver, motion
constexpr double averaged = 150;      // additional, with averaged stress: neighbours, balls
constexpr double followed = 37;       // additional, where cracks are followed: delays, tetrahedra at nodes
constexpr double by_means = 20;       // additional, with nucleation by means around nodes: sums, marks
constexpr double touching = 12;       // additional, with contact: surfaces
constexpr double pushed = 75;         // additional, with each body force: weights, work, remainders
constexpr double viscous = 85;        // additional, with bulk viscosity: coefficients, forces, remainders
constexpr double repeated = 8;        // per node of the body, on each of several ranks: cells of the solver
constexpr double kept = 30;           // per tetrahedron of a realization
constexpr double made = 180;          // per tetrahedron of a realization being made or partitioned
constexpr double placed = 240;        // per mother point that a rank helps to place
constexpr double frame_kept = 24;     // per node of a frame
constexpr double frame_written = 66;  // the same while the file is written, after the computation
constexpr double tetrahedra_per_node = 6;  // of a mesh that is large for its surface

/// First number after `key` in a file of lines "key number ..."; empty if there is none.
std::optional<double> number_after(const fs::path& file, const std::string& key) {
  std::ifstream stream(file);
  for (std::string line; std::getline(stream, line);) {
    std::istringstream words(line);
    std::string word;
    double number = 0;
    if (words >> word && word == key && words >> number) return number;
  }
  return std::nullopt;
}

/// The only number in a file; empty for "max" and the like.
std::optional<double> number_in(const fs::path& file) {
  std::ifstream stream(file);
  double number = 0;
  if (stream >> number) return number;
  return std::nullopt;
}

/// File names of a version of control groups.
struct GroupFiles {
  const char* mount;
  const char* limit;
  const char* usage;
  const char* cached;  // key in memory.stat
};
constexpr GroupFiles version_2{"sys/fs/cgroup", "memory.max", "memory.current", "inactive_file"};
constexpr GroupFiles version_1{"sys/fs/cgroup/memory", "memory.limit_in_bytes", "memory.usage_in_bytes",
                               "total_inactive_file"};

/// Memory left by the group and its ancestors. In a container, the mount's root may be its own group.
void look_at_groups(const fs::path& root, const GroupFiles& files, const std::string& group,
                    AvailableMemory& least) {
  const fs::path mount = root / files.mount;
  for (fs::path path = fs::path(group).relative_path();; path = path.parent_path()) {
    const fs::path folder = mount / path;
    const auto limit = number_in(folder / files.limit);
    const auto usage = number_in(folder / files.usage);
    if (limit && usage) {
      const double cached = number_after(folder / "memory.stat", files.cached).value_or(0);
      const double left = std::max(0.0, *limit - std::max(0.0, *usage - cached));
      if (left < least.bytes) least = {left, "control group /" + path.string()};
    }
    if (path.empty()) return;
  }
}

/// Resident memory of this process [byte].
double resident() {
  std::ifstream stream("/proc/self/statm");
  double total = 0;
  double pages = 0;
  return stream >> total >> pages ? pages * static_cast<double>(sysconf(_SC_PAGESIZE)) : 0;
}

double expected_nodes(const input::Mesh& mesh, const geometry::Body& body) {
  if (mesh.points) return static_cast<double>(geometry::read_points(*mesh.points, body).size());
  return geometry::estimate_n_points(body, mesh);
}

/// To make a realization.
double making(const std::optional<input::MaterialMap>& map, double n_tetrahedra) {
  return made * n_tetrahedra + (map ? io::raster_memory(*map) : 0);
}

}  // namespace

double MemoryDemand::of_rank(const GroupLayout& layout, int rank) const {
  const int group = layout.group_of(rank);
  const double own = rank == 0 ? master : group < 0 ? idle : rank == layout.root_of(group) ? root : member;
  return rank < most_placing ? std::max(own, placing) : own;
}

MemoryDemand memory_demand(const input::Study& study, double n_nodes, double n_tetrahedra,
                           const GroupLayout& layout, std::optional<double> largest_part) {
  const bool by_mean = study.fracture_of(0).nucleates_by_means();
  const double each = computed + (study.fracture.length > 0 ? averaged : 0) +
                      (by_mean || study.fracture_of(0).separates_nucleation() ? followed : 0) +
                      (by_mean ? by_means : 0) + (study.any_contact() ? touching : 0) +
                      (study.bulk_viscosity().acts() ? viscous : 0) +
                      pushed * static_cast<double>(study.body_forces().size());
  const bool is_shared = layout.ranks_per_group > 1;
  const double part = each * largest_part.value_or(compact_part(n_tetrahedra, layout.ranks_per_group)) +
                      (is_shared ? repeated * n_nodes : 0);
  const double frames = study.output.frames * n_nodes;
  const double ahead = queue_limits(layout.n_groups).most_held(kept * n_tetrahedra);
  const double start = libraries;
  MemoryDemand demand{};
  const bool is_placed = study.mesh.base == input::Base::shared && !study.mesh.points;
  demand.idle = start;
  demand.placing = start + (is_placed ? placed * n_nodes : 0);
  demand.member = start + part;
  demand.root = start + kept * n_tetrahedra + std::max(part + frame_kept * frames, frame_written * frames);
  if (is_shared || study.ensemble.meshes != input::MeshMakers::master)
    demand.root = std::max(demand.root, start + making(study.map, n_tetrahedra));
  const bool groups_make_all = study.ensemble.meshes == input::MeshMakers::groups;
  demand.master = groups_make_all ? start : start + making(study.map, n_tetrahedra) + ahead;
  if (layout.shared()) demand.master = std::max(start + making(study.map, n_tetrahedra), demand.root);
  return demand;
}

MemoryDemand expected_memory_demand(const input::Study& study, const geometry::Body& body,
                                    const GroupLayout& layout) {
  const double n_nodes = expected_nodes(study.mesh, body);
  return memory_demand(study, n_nodes, tetrahedra_per_node * n_nodes, layout);
}

double expected_mesh_memory(const input::Model& model, const geometry::Body& body) {
  return libraries + making(model.map, tetrahedra_per_node * expected_nodes(model.mesh, body));
}

AvailableMemory available_memory(const fs::path& root) {
  AvailableMemory least{infinity, "nothing"};
  if (const auto kilobytes = number_after(root / "proc/meminfo", "MemAvailable:"))
    least = {1024 * *kilobytes, "memory of the node"};
  std::ifstream groups(root / "proc/self/cgroup");
  for (std::string line; std::getline(groups, line);) {
    // "0::/path" in version 2, "4:memory:/path" in version 1
    const auto first = line.find(':');
    const auto second = line.find(':', first + 1);
    if (first == std::string::npos || second == std::string::npos) continue;
    const std::string controllers = line.substr(first + 1, second - first - 1);
    const std::string path = line.substr(second + 1);
    if (controllers.empty()) look_at_groups(root, version_2, path, least);
    if (("," + controllers + ",").find(",memory,") != std::string::npos)
      look_at_groups(root, version_1, path, least);
  }
  return least;
}

std::optional<std::string> shortage(double needed, const std::string& whose,
                                    const AvailableMemory& available) {
  if (needed <= available.bytes) return std::nullopt;
  return fmt::format("memory: {} need{} about {:.3g} GB, and {:.3g} GB are available ({})", whose,
                     whose.find("ranks") == std::string::npos ? "s" : "", needed / 1e9, available.bytes / 1e9,
                     available.limit);
}

void check_available(double needed, const std::string& whose, const AvailableMemory& available) {
  if (const auto message = shortage(needed, whose, available)) {
    throw std::runtime_error(*message + "; use coarser spacings, more nodes, or more ranks_per_sample");
  }
}

void check_memory(const parallel::Communicator& world, const input::Study& study, const geometry::Body& body,
                  const GroupLayout& layout, bool has_work) {
  MemoryDemand demand{};
  parallel::agree_on_root(world, [&] {
    if (has_work) demand = expected_memory_demand(study, body, layout);
  });
  demand = parallel::share(world, demand);
  MPI_Comm on_node = MPI_COMM_NULL;
  parallel::check_mpi(
      MPI_Comm_split_type(world.get(), MPI_COMM_TYPE_SHARED, world.rank(), MPI_INFO_NULL, &on_node),
      "MPI_Comm_split_type");
  const parallel::Communicator node(on_node);
  MPI_Comm_free(&on_node);
  double needed = std::max(0.0, demand.of_rank(layout, world.rank()) - resident());
  needed = parallel::all_reduce(node, needed, MPI_SUM);
  parallel::agree(world, [&] {
    if (!node.is_root()) return;
    std::array<char, 256> name{};
    ::gethostname(name.data(), name.size() - 1);
    check_available(needed,
                    node.size() == 1 ? fmt::format("one rank on {}", name.data())
                                     : fmt::format("{} ranks on {}", node.size(), name.data()),
                    available_memory());
  });
}

}  // namespace crackle::ensemble
