// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "dynamics/explicit_phase.h"
#include "dynamics/parting_watch.h"

#include <cstdint>
#include <functional>
#include <span>
#include <vector>

namespace crackle::dynamics {

/// Decides whether a dynamic phase ends: by arrest, some time after the body has separated, or by its
/// duration. Steps of the last break must be agreed, so that all ranks decide alike.
class PhaseEnd {
public:
  /// Collective. The context's members and the options must outlive the object.
  PhaseEnd(const MotionContext& context, const PhaseOptions& options);

  /// The step at which the phase ends at the latest.
  std::int64_t last_step() const { return last_step_; }

  /// True if nothing has broken for the time of the arrest window, or in the whole phase. See
  /// PhaseOptions::awaits_break.
  bool is_arrested(std::int64_t step, std::int64_t last_break) const;

  /// True if a check for separation is due: they are rare, and only after new breaks.
  bool must_check_separation(std::int64_t step, std::int64_t last_break) const;
  /// Notes local tetrahedra whose stiffness has changed. Local.
  void note(std::span<const std::int32_t> changed) { watch_.note(changed); }
  /// Notes that the conditions have changed. Local, on every rank.
  void note_new_conditions() { watch_.forget(); }
  /// Looks at the pieces only if the changes since the last check may have parted what matters. Collective;
  /// does not call check_peers() after.
  /// @param labels of the pieces, see fracture::piece_labels(); collective
  void check_separation(std::int64_t step, std::int64_t last_break,
                        const std::function<const std::vector<std::int64_t>&()>& labels);

  /// True if the phase ends after this step.
  bool is_reached(std::int64_t step, std::int64_t last_break) const;

  const Separation& separation() const { return separation_; }
  void restore(const Separation& separation) { separation_ = separation; }

private:
  MotionContext context_;
  const PhaseOptions* options_;
  std::int64_t last_step_;
  Separation separation_;
  PartingWatch watch_;
};

}  // namespace crackle::dynamics
