// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "common/real.h"
#include "dynamics/moving_body.h"
#include "dynamics/sample_result.h"
#include "fracture/material_field.h"
#include "geometry/subdomain.h"
#include "input/model.h"
#include "parallel/communicator.h"

#include <cstddef>
#include <functional>
#include <span>
#include <string>
#include <vector>

namespace crackle::dynamics {

/// One line about the sample's progress ("t0 = 76.2 s, 381 N, dynamic phase 3 starts"); called on the root
/// only.
using SampleLog = std::function<void(const std::string& line)>;

/// Control and output of a running sample, apart from the mechanics.
struct SampleControl {
  std::uint64_t sample = 0;  ///< its number, on which the material's random field depends
  SampleLog log;             ///< may be empty
  /// Status line of the sample, updated many times in a phase and replacing the previous one; used instead of
  /// the log's lines about a running phase. Called on the root; may be empty.
  SampleLog progress;
  std::function<bool()> stop;  ///< true if this rank was asked to suspend the sample; may be empty
  /// Stores a checkpoint; given on every rank or on none, called on the root. An exception is logged, and the
  /// sample continues.
  std::function<void(std::span<const std::byte> checkpoint)> save;
  std::vector<std::byte>
      checkpoint;  ///< on the root: last checkpoint to continue from; empty: from the start
  double checkpoint_interval = infinity;  ///< minimum wall time between checkpoints [s]
  /// Receives the partial results of a failing sample, before the failure is thrown; given on every rank or
  /// on none.
  std::function<void(SampleResult partial)> failed = {};
  std::vector<MakeTerm> more_terms = {};  ///< contributions to the motion, and to equilibria
};

/// Time without a break after which a dynamic phase counts as arrested [s]: from the input, or the time that
/// a bar wave in the slowest material takes along the body's longest extent. By then a crack half-way along
/// has received the response of both ends to its last break; later arrivals have been reflected again.
/// @param size of the body [m]
double arrest_window(const input::Time& time, const Vector& size, const fracture::BodyWaves& waves);

/// Time that a plane dilatational wave in the slowest material takes along the body's longest extent [s].
double wave_transit(const Vector& size, const fracture::BodyWaves& waves);

/// Computes one sample from the unloaded state to its end: quasi-static loading, instability, dynamic
/// fracture, arrest. Collective over the group; a failure on one rank is thrown on all.
///
/// If any rank is asked to, the sample is suspended within 32 steps of a dynamic phase, or between two
/// quasi-static breaks or increments of the loads. Continuing from a checkpoint, on any number of ranks,
/// gives bitwise the same results as an uninterrupted run: quasi-static loading is recomputed, dynamic phases
/// are not. With Engine::petsc this holds for the same number of ranks only. A checkpoint that does not match
/// the sample is logged and ignored.
///
/// A sample that leaves the range of mixed precision is recomputed in double from its start; its later
/// checkpoints are in double as well.
/// @param output what is recorded over time
/// @param subdomain this rank's part of the realization
SampleResult run_sample(const parallel::Communicator& group, const input::Model& model,
                        const input::Output& output, const geometry::Subdomain& subdomain,
                        const SampleControl& control = {});

}  // namespace crackle::dynamics
