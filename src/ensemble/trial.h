// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "ensemble/case.h"

#include <cstdint>
#include <string>

namespace crackle::ensemble {

/// Extent of a trial.
enum class TrialDepth {
  setup,  ///< mesh, loads, strengths, and whether the body is sufficiently supported
  start,  ///< also the first equilibrium, or the first steps of a sample that starts from rest
};

/// Starts samples with the steps of `crackle run`, without writing anything, to detect early failures before
/// the run.
class Trial {
public:
  /// The references must outlive the object.
  /// @param base points shared by all samples; unused with mesh.base = "own"
  Trial(const input::Parameters& parameters, const geometry::Body& body, const geometry::MotherPoints& base,
        TrialDepth depth);

  /// The reason for which the sample would fail in a run; empty if it starts successfully. Not collective.
  /// @param made the sample's realization; null: it is made
  std::string failure(std::uint64_t sample, const geometry::Realization* made = nullptr) const;

private:
  Case case_;
};

}  // namespace crackle::ensemble
