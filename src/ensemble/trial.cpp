// SPDX-License-Identifier: GPL-3.0-or-later
#include "ensemble/trial.h"

#include "dynamics/sample_setup.h"
#include "parallel/agreement.h"

#include "case_sample.h"

#include <optional>

namespace crackle::ensemble {

namespace {

/// Sets up a sample and suspends it immediately.
dynamics::SampleResult set_up_only(const parallel::Communicator& group, const input::Model& model,
                                   const input::Output&, const geometry::Subdomain& subdomain,
                                   const dynamics::SampleControl& control) {
  const dynamics::SampleSetup setup(group, model, subdomain, control.sample);
  if (model.time.start != input::Start::rest) setup.refuse_free_body();
  dynamics::SampleResult result;
  result.suspended = true;
  return result;
}

/// The caller's object, as a pointer.
template <class Object>
std::shared_ptr<const Object> not_owned(const Object& object) {
  return {std::shared_ptr<void>(), &object};
}

}  // namespace

Trial::Trial(const input::Parameters& parameters, const geometry::Body& body,
             const geometry::MotherPoints& base, TrialDepth depth)
    : case_(parameters, not_owned(body), not_owned(base),
            depth == TrialDepth::start ? Mechanics(dynamics::run_sample) : Mechanics(set_up_only)) {}

std::string Trial::failure(std::uint64_t sample, const geometry::Realization* made) const {
  const char* stage = "mesh: ";  // as in a run
  try {
    CaseSample steps(case_, sample);
    std::optional<geometry::Realization> own;
    if (made == nullptr) made = &own.emplace(steps.make());
    stage = "partition: ";
    const auto parts = steps.split(*made, 1);
    dynamics::SampleControl control;
    control.stop = [] { return true; };
    stage = "computation: ";
    steps.compute(parallel::Communicator(MPI_COMM_SELF), parts.front(), std::move(control));
  } catch (...) {
    return stage + parallel::current_error();
  }
  return {};
}

}  // namespace crackle::ensemble
