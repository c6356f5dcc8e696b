// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "common/index.h"
#include "ensemble/case.h"
#include "input/reader.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <numeric>
#include <string>
#include <vector>

/// A small plate, with a cheap rule instead of the mechanics.
namespace crackle::ensemble {

/// @param more further lines of the input, after [ensemble]
inline input::Parameters plate(int samples, int ranks_per_sample, const std::string& more = "") {
  return input::parse(fmt::format(R"([ensemble]
samples = {}
seed = 7
ranks_per_sample = {}
{}[specimen]
size = ["4 mm", "20 mm", "30 mm"]
[[specimen.notch]]
face = "y-min"
at = "13 mm"
depth = "5 mm"
height = "2 mm"
[[specimen.notch]]
face = "y-max"
at = "18 mm"
depth = "5 mm"
height = "2 mm"
[mesh]
base = "shared"
spacing = "3 mm"
notch_spacing = "1.5 mm"
growth = 0.2
perturbation = 0.2
min_quality = 0.1
[material]
youngs_modulus = "3300 MPa"
poisson_ratio = 0.38
density = "1180 kg/m^3"
[fracture]
strength = "35 MPa"
exponent = 2
impulse = "1e-8 MPa^2 s"
accumulation = "cumulative"
release = "element"
[[boundary]]
on = "z-min"
fix = ["x", "y", "z"]
[[boundary]]
on = "z-max"
force = ["0 N", "0 N", "135 N"]
[time]
step = "5 ns"
duration = "1 us"
[sections]
y = ["6 mm", "10 mm", "14 mm"]
)",
                                  samples, ranks_per_sample, more),
                      "plate.toml");
}

/// Breaks the tetrahedra whose centroid lies in a strip behind the first notch, in the order of their
/// numbers: equal for any partition.
inline dynamics::SampleResult break_strip(const parallel::Communicator& group, std::uint64_t sample,
                                          const geometry::Subdomain& subdomain) {
  std::vector<std::int64_t> mine;
  for (std::size_t i = 0; i < subdomain.tetrahedra.size(); ++i) {
    if (subdomain.owned[i] == 0) continue;
    double y = 0, z = 0;
    for (const auto node : subdomain.tetrahedra[i]) {
      y += subdomain.nodes[index(node)][1] / 4;
      z += subdomain.nodes[index(node)][2] / 4;
    }
    if (y > 4e-3 && std::abs(z - 13e-3) < 1.5e-3) mine.push_back(subdomain.tetrahedron_number[i]);
  }
  int count = static_cast<int>(mine.size());
  std::vector<int> counts(static_cast<std::size_t>(group.size()));
  MPI_Allgather(&count, 1, MPI_INT, counts.data(), 1, MPI_INT, group.get());
  std::vector<int> starts(counts.size());
  std::exclusive_scan(counts.begin(), counts.end(), starts.begin(), 0);
  std::vector<std::int64_t> all(static_cast<std::size_t>(starts.back() + counts.back()));
  MPI_Allgatherv(mine.data(), count, MPI_INT64_T, all.data(), counts.data(), starts.data(), MPI_INT64_T,
                 group.get());
  std::sort(all.begin(), all.end());
  dynamics::SampleResult result;
  result.outcome = dynamics::Outcome::separated;
  result.onset_time = 76;
  result.phase_start = 76;
  result.onset_force = 380 + static_cast<double>(sample);
  result.time_step = 5e-9;
  result.stable_step = 8e-9;
  result.energy.push_back({0, 0, 1, 1, 0, 0, 0});
  for (std::size_t i = 0; i < all.size(); ++i) {
    result.breaks.push_back({all[i], 76, 1e-6 * static_cast<double>(i + 1), 35e6, 1e-9, 0});
  }
  return result;
}

inline const Mechanics strip = [](const parallel::Communicator& group, const input::Model&,
                                  const input::Output&, const geometry::Subdomain& subdomain,
                                  const dynamics::SampleControl& control) {
  return break_strip(group, control.sample, subdomain);
};

}  // namespace crackle::ensemble
