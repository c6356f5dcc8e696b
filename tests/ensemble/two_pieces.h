// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "dynamics/sample_run.h"
#include "parallel/agreement.h"

#include <cstddef>
#include <span>
#include <utility>
#include <vector>

namespace crackle::dynamics {

/// A sample that is suspended in a dynamic phase and continued, to include saving and restoring.
inline SampleResult in_two_pieces(const parallel::Communicator& group, const input::Model& model,
                                  const input::Output& output, const geometry::Subdomain& subdomain,
                                  const SampleControl& given = {}) {
  SampleResult result;
  parallel::run_collectively(group, [&] {
    std::vector<std::byte> saved;
    bool is_saved = false;
    SampleControl control = given;
    control.save = [&](std::span<const std::byte> bytes) { saved.assign(bytes.begin(), bytes.end()); };
    // The first save is due at the first poll of a dynamic phase, and at the second one the sample is
    // suspended.
    control.checkpoint_interval = 0;
    control.stop = [&] { return group.is_root() && !saved.empty() && std::exchange(is_saved, true); };
    result = run_sample(group, model, output, subdomain, control);
    if (!result.suspended) return;
    control.stop = {};
    control.checkpoint_interval = given.checkpoint_interval;
    control.checkpoint = saved;
    result = run_sample(group, model, output, subdomain, control);
  });
  return result;
}

}  // namespace crackle::dynamics
