// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "crackle/parallel/communicator.h"

#include <chrono>
#include <optional>

/// Waits that leave the core to others. MPI's own blocking calls poll without pause, so a rank that waits in
/// them for seconds takes a core from a rank that computes.
namespace crackle::parallel {

/// Pauses between two looks: short at first, so that a quick answer costs no time, then longer and longer.
class BackOff {
public:
  static constexpr std::chrono::nanoseconds shortest{20'000};
  static constexpr std::chrono::nanoseconds longest{10'000'000};

  void sleep();                        ///< pauses, and doubles the next pause up to the longest
  void reset() { pause_ = shortest; }  ///< after something has happened
  std::chrono::nanoseconds next() const { return pause_; }

private:
  std::chrono::nanoseconds pause_ = shortest;
};

/// A message that has arrived and was not received yet, or nothing.
std::optional<MPI_Status> poll_message(const Communicator& group, int source, int tag);

/// Sleeps until a message from `source` (or MPI_ANY_SOURCE) has arrived; does not receive it.
MPI_Status wait_for_message(const Communicator& group, int source, int tag);

/// Sleeps until every rank of the group has come here. Collective.
void barrier_asleep(const Communicator& group);

}  // namespace crackle::parallel
