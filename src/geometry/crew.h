// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "input/model.h"

#include <array>
#include <cstdint>
#include <functional>
#include <span>
#include <vector>

namespace crackle::geometry {

/// Workers that place mother points together: each computes a part of every step, and all get all points. The
/// points do not depend on the number of workers. Worker 0 leads.
class Crew {
public:
  virtual ~Crew() = default;
  virtual std::size_t size() const = 0;
  virtual std::size_t rank() const = 0;  ///< number of this worker, from 0

  /// The leader's: runs `work` while the others, which must be waiting for this call, run
  /// help_mother_points() with these regions of the mesh. Collective. @throws std::runtime_error on all
  /// workers if any of them fails
  virtual void run(const std::vector<input::MeshRegion>& regions, const std::function<void()>& work) = 0;

  /// Gives every worker the values of all: those of worker r are first[r] to first[r + 1] - 1. Collective.
  virtual void share(std::span<double> values, std::span<const std::size_t> first) = 0;
  /// The pairs of all workers in their order. Collective.
  virtual std::vector<std::array<std::int32_t, 2>> gather(
      std::span<const std::array<std::int32_t, 2>> mine) = 0;
};

}  // namespace crackle::geometry
