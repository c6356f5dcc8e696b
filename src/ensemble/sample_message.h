// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "crackle/ensemble/realization_queue.h"
#include "crackle/ensemble/sample_report.h"
#include "crackle/parallel/communicator.h"

#include <optional>
#include <string>

/// Messages between the master and the roots of the groups.
namespace crackle::ensemble {

/// Root of a group to the master: asks for work, and reports the sample that was under way, if any.
void send_request(const parallel::Communicator& world, const std::optional<SampleReport>& report);

struct Request {
  int rank = 0;  ///< that asks
  std::optional<SampleReport> report;
};

/// Master: a request that has arrived, or nothing.
std::optional<Request> poll_request(const parallel::Communicator& world);

/// Master: answers a request with a realization, or with the end of the work.
void send_work(const parallel::Communicator& world, int rank, const PreparedSample& prepared);
void send_no_work(const parallel::Communicator& world, int rank);

/// Master: asks a group that is at work to park its sample.
void send_stop(const parallel::Communicator& world, int rank);
/// Root of a group: whether the master has asked for that.
bool is_asked_to_stop(const parallel::Communicator& world);
/// Root of a group whose work has ended: takes a request that came too late.
void discard_stop(const parallel::Communicator& world);

/// Root of a group to the master: the line that says where its sample stands.
void send_progress(const parallel::Communicator& world, const std::string& line);
/// Master: such a line that has arrived, or nothing.
std::optional<std::string> poll_progress(const parallel::Communicator& world);

/// Root of a group: sleeps until the answer comes; nothing when the work has ended.
std::optional<PreparedSample> receive_work(const parallel::Communicator& world);

}  // namespace crackle::ensemble
