// SPDX-License-Identifier: GPL-3.0-or-later
// The energy balance of a whole sample of the demo: external work = kinetic + strain + released + dissipated
// at every output.
#include "dynamics/energy_account.h"
#include "dynamics/sample_run.h"
#include "support/effort.h"
#include "support/job.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <tuple>
#include <vector>

namespace crackle::dynamics {
namespace CRACKLE_TEST_FILE {

double imbalance(const EnergyRow& row) {
  return row.external - row.kinetic - row.strain - row.released - row.dissipated;
}

class WholeSample : public ::testing::TestWithParam<std::tuple<input::Release, input::Precision>> {};

TEST_P(WholeSample, ClosesTheEnergyAccount) {
  auto parameters = test::job("demo.toml");
  ASSERT_EQ(parameters.time.integrator, input::Integrator::bilateral4);
  std::tie(parameters.fracture.release, parameters.time.precision) = GetParam();
  parameters.output.frames = 0;
  parameters.mesh.notch_spacing *= test::is_full() ? 1.5 : 2;  // in less time, and still enough breaks
  const auto mesh = test::realization(parameters, 5);
  const parallel::Communicator self(MPI_COMM_SELF);
  const auto result = run_sample(self, parameters, parameters.output, test::whole(mesh));

  double work = 0, between = 0;
  for (const auto& row : result.energy) work = std::max(work, std::abs(row.external));
  int n_quiet = 0;
  for (std::size_t i = 0, first = 0; i < result.energy.size(); ++i) {
    if (result.energy[i].broken != result.energy[first].broken) first = i;
    if (first == i) continue;
    ++n_quiet;
    between =
        std::max(between, std::abs(imbalance(result.energy[i]) - imbalance(result.energy[first])) / work);
  }
  std::printf(
      "release %s, precision %s: %zu breaks, largest relative error of the energy %.1e over %zu outputs "
      "(required 1e-4), change between breaks %.1e over %d of them (required 1e-6), range restarts %lld\n",
      parameters.fracture.release == input::Release::element ? "element" : "facet",
      parameters.time.precision == input::Precision::mixed ? "mixed" : "double", result.breaks.size(),
      result.energy_error, result.energy.size(), between, n_quiet,
      static_cast<long long>(result.counts.range_restarts));
  EXPECT_GT(result.breaks.size(), test::is_full() ? 500U : 300U);
  EXPECT_EQ(result.counts.range_restarts, 0);
  // Far below the requirement, so that a small fault in one part is detected.
  EXPECT_LT(result.energy_error, 5e-6);
  EXPECT_GT(n_quiet, 5);
  EXPECT_LT(between, 1e-6);
}

/// Each release and each precision once; under tools/check --full all pairs of them.
std::vector<std::tuple<input::Release, input::Precision>> pairs() {
  std::vector<std::tuple<input::Release, input::Precision>> result{
      {input::Release::element, input::Precision::mixed}, {input::Release::facet, input::Precision::double_}};
  if (test::is_full()) {
    result.emplace_back(input::Release::element, input::Precision::double_);
    result.emplace_back(input::Release::facet, input::Precision::mixed);
  }
  return result;
}

INSTANTIATE_TEST_SUITE_P(Demo, WholeSample, ::testing::ValuesIn(pairs()));

}  // namespace CRACKLE_TEST_FILE
}  // namespace crackle::dynamics
