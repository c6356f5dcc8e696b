// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "crackle/ensemble/sample_task.h"
#include "crackle/geometry/body.h"
#include "crackle/geometry/mother_points.h"
#include "crackle/input/parameters.h"

#include <cstdint>
#include <string>

namespace crackle::ensemble {

/// How far a trial goes.
enum class TrialDepth {
  setup,  ///< mesh, loads, strengths, and whether the conditions hold the body
  start,  ///< and the first equilibrium, or the first steps of a sample that starts from rest
};

/// Begins samples by the code that `crackle run` computes them with, and writes nothing: what would make one
/// fail that early is known before the run.
class Trial {
public:
  /// The references must outlive the object.
  /// @param base points that all samples share; not looked at with mesh.base own
  Trial(const input::Parameters& parameters, const geometry::Body& body, const geometry::MotherPoints& base,
        TrialDepth depth);

  /// The reason that the run would give for the sample's failure; empty where it begins well. Not collective.
  std::string failure(std::uint64_t sample);
  /// The same for a sample whose mesh is made.
  std::string failure(PreparedSample prepared);

private:
  SampleSteps steps_;
  SampleGroup self_;
};

}  // namespace crackle::ensemble
