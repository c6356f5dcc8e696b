// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <functional>
#include <optional>
#include <string>

/// Why a run may have to stop before it is complete.
namespace crackle::ensemble {

/// Tells whether and why this rank was asked to stop; once it has a reason it keeps it. Local, cheap.
using StopRequest = std::function<std::optional<std::string>()>;

/// From now on the first SIGTERM, SIGINT or SIGUSR1 asks to stop, and a second one ends the process at once,
/// with status 3.
void watch_stop_signals();

/// The request by a signal.
std::optional<std::string> stop_signal();

/// Seconds from now to the end of the time that this process has: the smaller one of the limit and what
/// SLURM_JOB_END_TIME leaves; nothing without either.
std::optional<double> time_left(std::optional<double> limit);

/// How long before the end of its time a run of `seconds` begins to park: a minute, or a tenth if that is
/// less.
double parking_reserve(double seconds);

/// The request by a signal, or by the end of the time coming near.
StopRequest make_stop_request(std::optional<double> limit);

/// Whether this rank stops: asks until there is a reason, tells it once, and says yes from then on.
class StopLatch {
public:
  /// @param request, tell may be empty
  StopLatch(StopRequest request, std::function<void(const std::string& line)> tell);
  bool operator()();
  /// Stops for a reason that is known elsewhere.
  void set() { is_set_ = true; }
  bool is_set() const { return is_set_; }

private:
  StopRequest request_;
  std::function<void(const std::string& line)> tell_;
  bool is_set_ = false;
};

}  // namespace crackle::ensemble
