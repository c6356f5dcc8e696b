// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "crackle/ensemble/sample_task.h"
#include "crackle/geometry/body.h"
#include "crackle/input/parameters.h"

#include <cstdint>
#include <functional>
#include <memory>
#include <mutex>
#include <optional>
#include <utility>

namespace crackle::ensemble {

/// Input and body of one sample.
struct SampleInput {
  input::Parameters parameters;
  std::shared_ptr<const geometry::Body> body;
};

/// The input and the body of each sample: the ensemble's own or, with random inputs, those of its draw.
/// Thread-safe.
class SampleInputs {
public:
  /// @param parameters, body of the ensemble; both must outlive this
  SampleInputs(const input::Parameters& parameters, const geometry::Body& body);

  /// @throws std::runtime_error when the drawn values make an invalid input
  std::shared_ptr<const SampleInput> of(std::uint64_t sample) const;

private:
  using Draw = std::pair<std::uint64_t, std::shared_ptr<const SampleInput>>;

  const input::Parameters& parameters_;
  std::shared_ptr<const SampleInput> own_;  ///< null with random inputs
  mutable std::mutex mutex_;
  mutable std::optional<Draw> last_;
};

/// As SampleFunction, with the input of the sample.
using InputFunction = std::function<dynamics::SampleResult(
    const parallel::Communicator& group, const input::Parameters& own, std::uint64_t sample,
    const geometry::Subdomain& subdomain, const dynamics::SampleControl& control)>;

/// Calls a function with each sample's own input. The reference must outlive the result.
SampleFunction with_own_input(const input::Parameters& parameters, InputFunction function);

/// A sample's mechanics by dynamics::run_sample, with its own input. The reference must outlive the function.
SampleFunction sample_mechanics(const input::Parameters& parameters);

}  // namespace crackle::ensemble
