// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "parallel/communicator.h"

#include <chrono>
#include <optional>

/// Waits that release the core. MPI's blocking calls poll continuously, so a rank that waits in them for
/// seconds takes a core from a rank that computes.
namespace crackle::parallel {

/// Pauses between polls: short at first, so that a quick answer costs no time, then increasingly long.
class BackOff {
public:
  static constexpr std::chrono::nanoseconds shortest{20'000};
  static constexpr std::chrono::nanoseconds longest{10'000'000};

  void sleep();                        ///< pauses, and doubles the next pause up to a maximum
  void reset() { pause_ = shortest; }  ///< call after something has happened
  std::chrono::nanoseconds next() const { return pause_; }

private:
  std::chrono::nanoseconds pause_ = shortest;
};

/// A message that has arrived but was not received yet; empty if there is none.
std::optional<MPI_Status> poll_message(const Communicator& group, int source, int tag);

/// Sleeps until a message from `source` (or MPI_ANY_SOURCE) has arrived; does not receive it.
MPI_Status wait_for_message(const Communicator& group, int source, int tag);

/// Sleeps until every rank of the group has arrived. Collective.
void barrier_asleep(const Communicator& group);

}  // namespace crackle::parallel
