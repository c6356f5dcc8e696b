// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <functional>
#include <optional>
#include <string>

/// Requests to stop a run before it is complete.
namespace crackle::ensemble {

/// Returns the reason if this rank was asked to stop; once set, the reason persists. Local, cheap.
using StopRequest = std::function<std::optional<std::string>()>;

/// From now on the first SIGTERM, SIGINT or SIGUSR1 requests a stop; a second one ends the process at once
/// with status 3.
void watch_stop_signals();

/// The stop request by signal.
std::optional<std::string> stop_signal();

/// Seconds until this process runs out of time: the smaller of the limit and the time left until
/// SLURM_JOB_END_TIME; empty without either.
std::optional<double> time_left(std::optional<double> limit);

/// How long before its end a run of `seconds` begins to suspend its samples: one minute, or a tenth of the
/// run if that is less.
double suspending_reserve(double seconds);

/// Stop request by signal or by the approaching time limit.
/// @param is_root a run's time is that of its root, whose log names the limit; other ranks watch signals only
StopRequest make_stop_request(std::optional<double> limit, bool is_root);

/// Latched stop request: polls until there is a reason, reports it once, and returns true from then on.
class StopLatch {
public:
  StopLatch() = default;  ///< never asked
  /// @param request, tell may be empty
  StopLatch(StopRequest request, std::function<void(const std::string& line)> tell);
  bool operator()();
  /// Stops for a reason known elsewhere.
  void set() { is_set_ = true; }
  bool is_set() const { return is_set_; }

private:
  StopRequest request_;
  std::function<void(const std::string& line)> tell_;
  bool is_set_ = false;
};

}  // namespace crackle::ensemble
