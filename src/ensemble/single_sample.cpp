// SPDX-License-Identifier: GPL-3.0-or-later
#include "crackle/ensemble/single_sample.h"

#include "crackle/ensemble/sample_plan.h"
#include "crackle/parallel/agreement.h"
#include "crackle/parallel/sleeping_wait.h"

#include <fmt/format.h>

#include <stdexcept>
#include <utility>

namespace crackle::ensemble {

SampleReport run_single_sample(const parallel::Communicator& ranks, const input::Parameters& parameters,
                               const std::filesystem::path& folder, std::uint64_t sample,
                               const SampleFunction& sample_function, const dynamics::SampleLog& log) {
  const geometry::Body body = parallel::agree(ranks, [&] { return geometry::Body(parameters.specimen); });
  geometry::MotherPoints base;
  SampleSteps steps = make_sample_steps(parameters, body, base, folder, ranks.size(), sample_function);
  steps.log = log;
  PreparedSample prepared;
  parallel::agree_on_root(ranks, [&] {
    if (sample >= static_cast<std::uint64_t>(parameters.ensemble.samples)) {
      throw std::runtime_error(fmt::format("there is no sample {}: ensemble.samples = {} has samples 0 to {}",
                                           sample, parameters.ensemble.samples,
                                           parameters.ensemble.samples - 1));
    }
    check_same_input(folder, parameters);
    base = geometry::make_mother_points(body, parameters.mesh, parameters.ensemble.seed);
    make_sample_folder(folder);
    prepared = prepare(steps.make, sample);
  });

  SampleGroup group(ranks);
  SampleReport report;
  if (group.is_root()) {
    report = prepared.failed() ? report_failure(steps, sample, prepared.error, prepared.seconds)
                               : lead_sample(group, steps, std::move(prepared));
    send_end(group);
  } else {
    follow_samples(group, steps);
  }
  parallel::barrier_asleep(ranks);
  parallel::check_mpi(MPI_Bcast(&report.summary.status, 1, MPI_INT32_T, 0, ranks.get()), "MPI_Bcast");
  return report;
}

}  // namespace crackle::ensemble
