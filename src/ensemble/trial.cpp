// SPDX-License-Identifier: GPL-3.0-or-later
#include "crackle/ensemble/trial.h"

#include "crackle/dynamics/sample_setup.h"

#include "case_sample.h"

#include <utility>

namespace crackle::ensemble {

namespace {

/// Sets up a sample and suspends it immediately.
dynamics::SampleResult set_up_only(const parallel::Communicator& group, const input::Parameters& parameters,
                                   const geometry::Subdomain& subdomain,
                                   const dynamics::SampleControl& control) {
  const dynamics::SampleSetup setup(group, parameters, subdomain, control.sample);
  if (parameters.time.start != input::Start::rest) setup.refuse_free_body();
  dynamics::SampleResult result;
  result.suspended = true;
  return result;
}

/// A sample that leaves no files.
class TriedSample final : public CaseSample {
public:
  using CaseSample::CaseSample;

  void write(const geometry::Realization&, const dynamics::SampleResult&, const SampleAnalysis&) override {}
  void write_failure(const analysis::SampleSummary&, const PartialSample*) override {}
  bool keeps_checkpoints() const override { return false; }
  void remove_checkpoint() override {}
};

/// The caller's object, as a pointer.
template <class Object>
std::shared_ptr<const Object> not_owned(const Object& object) {
  return {std::shared_ptr<void>(), &object};
}

}  // namespace

Trial::Trial(const input::Parameters& parameters, const geometry::Body& body,
             const geometry::MotherPoints& base, TrialDepth depth)
    : case_(parameters, not_owned(body), not_owned(base),
            depth == TrialDepth::start ? Mechanics(dynamics::run_sample) : Mechanics(set_up_only)),
      self_(parallel::Communicator(MPI_COMM_SELF)) {}

geometry::Realization Trial::make(std::uint64_t sample) {
  return CaseSample(case_, sample).make();
}

std::unique_ptr<SampleSteps> Trial::steps(std::uint64_t sample) {
  return std::make_unique<TriedSample>(case_, sample);
}

dynamics::SampleControl Trial::control() {
  dynamics::SampleControl control;
  control.stop = [] { return true; };
  return control;
}

std::string Trial::failure(std::uint64_t sample) {
  return failure(prepare(*this, sample));
}

std::string Trial::failure(PreparedSample prepared) {
  return lead_sample(self_, *this, control(), std::move(prepared)).summary.error;
}

}  // namespace crackle::ensemble
