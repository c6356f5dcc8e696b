// SPDX-License-Identifier: GPL-3.0-or-later
#include "crackle/ensemble/trial.h"

#include "crackle/dynamics/sample_setup.h"
#include "crackle/ensemble/sample_inputs.h"

#include <utility>

namespace crackle::ensemble {

namespace {

/// Sets up a sample and parks it immediately.
dynamics::SampleResult set_up_only(const parallel::Communicator& group, const input::Parameters& own,
                                   std::uint64_t sample, const geometry::Subdomain& subdomain,
                                   const dynamics::SampleControl&) {
  const dynamics::SampleSetup setup(group, own, subdomain, sample);
  if (own.time.start != input::Start::rest) setup.refuse_free_body();
  dynamics::SampleResult result;
  result.suspended = true;
  return result;
}

}  // namespace

Trial::Trial(const input::Parameters& parameters, const geometry::Body& body,
             const geometry::MotherPoints& base, TrialDepth depth)
    : steps_(make_sample_steps(parameters, body, base, {}, 1,
                               depth == TrialDepth::start ? sample_mechanics(parameters)
                                                          : with_own_input(parameters, set_up_only))),
      self_(parallel::Communicator(MPI_COMM_SELF)) {
  steps_.stop = [] { return true; };
  steps_.write = [](const auto&...) {};
  steps_.write_failure = [](const auto&...) {};
  steps_.read_checkpoint = {};
  steps_.write_checkpoint = {};
  steps_.remove_checkpoint = {};
}

std::string Trial::failure(std::uint64_t sample) {
  return failure(prepare(steps_.make, sample));
}

std::string Trial::failure(PreparedSample prepared) {
  const SampleReport report = prepared.failed()
                                  ? report_failure(steps_, prepared.sample, prepared.error, prepared.seconds)
                                  : lead_sample(self_, steps_, std::move(prepared));
  return report.summary.error;
}

}  // namespace crackle::ensemble
