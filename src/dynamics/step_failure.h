// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "parallel/agreement.h"
#include "parallel/communicator.h"

#include <optional>
#include <string>

namespace crackle::dynamics {

/// Holds a failure on this rank until agree(), so that no rank waits for one that has left the step.
class StepFailure {
public:
  /// @param group must outlive the object
  explicit StepFailure(const parallel::Communicator& group) : group_(&group) {}

  /// Local work; skipped after a failure.
  template <class Work>
  void guard(const Work& work) {
    if (!error_) guard_messages(work);
  }

  /// Work with communication: runs even after a failure, to avoid deadlock.
  template <class Work>
  void guard_messages(const Work& work) {
    try {
      work();
    } catch (...) {
      if (!error_) error_ = parallel::current_error(*group_);
    }
  }

  /// Collective. @throws parallel::AgreedError on every rank if any of them has failed
  void agree() const { parallel::agree_on_error(*group_, error_); }

private:
  const parallel::Communicator* group_;
  std::optional<std::string> error_;
};

}  // namespace crackle::dynamics
