// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "crackle/ensemble/case.h"

#include <cstdint>
#include <memory>
#include <string>

namespace crackle::ensemble {

/// Extent of a trial.
enum class TrialDepth {
  setup,  ///< mesh, loads, strengths, and whether the body is sufficiently supported
  start,  ///< also the first equilibrium, or the first steps of a sample that starts from rest
};

/// Starts samples with the same code as `crackle run`, without writing anything, to detect early failures
/// before the run.
class Trial final : private SampleSource {
public:
  /// The references must outlive the object.
  /// @param base points shared by all samples; unused with mesh.base = "own"
  Trial(const input::Parameters& parameters, const geometry::Body& body, const geometry::MotherPoints& base,
        TrialDepth depth);

  /// The reason for which the sample would fail in a run; empty if it starts successfully. Not collective.
  std::string failure(std::uint64_t sample);
  /// The same for a sample with a mesh.
  std::string failure(PreparedSample prepared);

private:
  geometry::Realization make(std::uint64_t sample) override;
  std::unique_ptr<SampleSteps> steps(std::uint64_t sample) override;
  dynamics::SampleControl control() override;

  Case case_;
  SampleGroup self_;
};

}  // namespace crackle::ensemble
