// SPDX-License-Identifier: GPL-3.0-or-later
#include "crackle/ensemble/sample_inputs.h"

#include "crackle/dynamics/sample_run.h"
#include "crackle/parallel/agreement.h"
#include "crackle/uncertainty/random_inputs.h"

namespace crackle::ensemble {

SampleInputs::SampleInputs(const input::Parameters& parameters, const geometry::Body& body)
    : parameters_(parameters) {
  // Non-owning pointer: the body belongs to the caller.
  if (parameters.random.empty())
    own_ = std::make_shared<const SampleInput>(SampleInput{parameters, {std::shared_ptr<void>(), &body}});
}

std::shared_ptr<const SampleInput> SampleInputs::of(std::uint64_t sample) const {
  if (own_) return own_;
  const std::uint64_t number = parameters_.ensemble.input_of(sample);
  const std::lock_guard lock(mutex_);
  if (!last_ || last_->first != number) {
    SampleInput input{uncertainty::sample_parameters(parameters_, sample), {}};
    input.body = geometry::make_body(input.parameters);
    last_.emplace(number, std::make_shared<const SampleInput>(std::move(input)));
  }
  return last_->second;
}

SampleFunction with_own_input(const input::Parameters& parameters, InputFunction function) {
  return [&parameters, function = std::move(function)](
             const parallel::Communicator& group, std::uint64_t sample, const geometry::Subdomain& subdomain,
             const dynamics::SampleControl& control) {
    if (parameters.random.empty()) return function(group, parameters, sample, subdomain, control);
    const input::Parameters own =
        parallel::agree(group, [&] { return uncertainty::sample_parameters(parameters, sample); });
    return function(group, own, sample, subdomain, control);
  };
}

SampleFunction sample_mechanics(const input::Parameters& parameters) {
  return with_own_input(parameters,
                        [](const parallel::Communicator& group, const input::Parameters& own, std::uint64_t,
                           const geometry::Subdomain& subdomain, const dynamics::SampleControl& control) {
                          return dynamics::run_sample(group, own, subdomain, control);
                        });
}

}  // namespace crackle::ensemble
