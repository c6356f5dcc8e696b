// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "crackle/common/real.h"
#include "crackle/dynamics/sample_result.h"
#include "crackle/geometry/subdomain.h"
#include "crackle/input/parameters.h"
#include "crackle/parallel/communicator.h"

#include <cstddef>
#include <functional>
#include <span>
#include <string>
#include <vector>

namespace crackle::dynamics {

/// One line about the sample's progress ("t0 = 76.2 s, 381 N, dynamic phase 3 starts"); called on the root
/// only.
using SampleLog = std::function<void(const std::string& line)>;

/// What a sample on its way does besides the mechanics.
struct SampleControl {
  std::uint64_t sample = 0;  ///< its number, which the random field of the material depends on
  SampleLog log;             ///< may be empty
  /// The line that says where the sample stands, which replaces the one before, many times in a phase; in
  /// place of the log's lines about a running phase. Called on the root; may be empty.
  SampleLog progress;
  std::function<bool()> stop;  ///< whether this rank was asked to park the sample; may be empty
  /// Keeps a checkpoint; given on every rank or on none, called on the root. What it throws is logged, and
  /// the sample goes on.
  std::function<void(std::span<const std::byte> checkpoint)> save;
  std::vector<std::byte>
      checkpoint;  ///< on the root: what was saved last, to continue from; empty: from the start
  double checkpoint_interval = infinity;  ///< wall time between two saves [s]
  /// Takes what there is of a sample that fails, before the failure is thrown; called on every rank or on
  /// none.
  std::function<void(SampleResult partial)> failed = {};
};

/// Time without a break after which a dynamic phase has arrested [s]: the input's, or what a longitudinal
/// wave in a bar takes along the body's longest extent. A crack half-way has heard by then how both ends
/// answered its last break; what comes later has been reflected again.
double arrest_window(const input::Parameters& parameters);

/// One body's way from the unloaded state to its end: quasi-static loading, instability, dynamic breaking,
/// arrest. Collective over the group; a failure on one rank is thrown on all.
///
/// When any rank is asked to, the sample is parked: within 32 steps of a dynamic phase, or between two
/// quasi-static breaks. From a checkpoint it goes on, on any number of ranks, to the same bits as without an
/// interruption: quasi-static loading is computed again, dynamic phases are not. With Engine::petsc the bits
/// are the same on the same number of ranks. A checkpoint that does not fit the sample is logged and not
/// used.
///
/// A sample that leaves the range of mixed numbers is computed again in double from its start, and from then
/// on its checkpoints go on in double.
/// @param subdomain this rank's part of the realization
SampleResult run_sample(const parallel::Communicator& group, const input::Parameters& parameters,
                        const geometry::Subdomain& subdomain, const SampleControl& control = {});

}  // namespace crackle::dynamics
