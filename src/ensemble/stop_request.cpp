// SPDX-License-Identifier: GPL-3.0-or-later
#include "ensemble/stop_request.h"

#include "common/stopwatch.h"
#include "common/whole_number.h"

#include <fmt/format.h>
#include <unistd.h>

#include <algorithm>
#include <csignal>
#include <cstdlib>
#include <ctime>
#include <utility>

namespace crackle::ensemble {

namespace {

volatile std::sig_atomic_t received = 0;

extern "C" void note_signal(int number) {
  constexpr int stopped_resumable = 3;
  if (received != 0) ::_exit(stopped_resumable);
  received = number;
}

}  // namespace

void watch_stop_signals() {
  struct sigaction action {};
  action.sa_handler = note_signal;
  sigemptyset(&action.sa_mask);
  action.sa_flags = SA_RESTART;
  for (const int number : {SIGTERM, SIGINT, SIGUSR1}) ::sigaction(number, &action, nullptr);
}

std::optional<std::string> stop_signal() {
  if (received == 0) return std::nullopt;
  return received == SIGTERM ? "SIGTERM" : received == SIGINT ? "SIGINT" : "SIGUSR1";
}

std::optional<double> time_left(std::optional<double> limit) {
  const char* text = std::getenv("SLURM_JOB_END_TIME");
  const auto job_end = whole_number<std::time_t>(text != nullptr ? text : "");
  if (!job_end || *job_end <= 0) return limit;
  const double job_limit = std::difftime(*job_end, std::time(nullptr));
  return limit ? std::min(*limit, job_limit) : job_limit;
}

double suspending_reserve(double seconds) {
  return std::min(60.0, 0.1 * seconds);
}

StopRequest make_stop_request(std::optional<double> limit, bool is_root) {
  const auto time = is_root ? time_left(limit) : std::nullopt;
  return [time, clock = Stopwatch()]() -> std::optional<std::string> {
    if (auto signal = stop_signal()) return signal;
    if (time && clock.seconds() >= *time - suspending_reserve(*time))
      return fmt::format("the time limit of {:.0f} s", *time);
    return std::nullopt;
  };
}

StopLatch::StopLatch(StopRequest request, std::function<void(const std::string& line)> tell)
    : request_(std::move(request)), tell_(std::move(tell)) {}

bool StopLatch::operator()() {
  if (is_set_ || !request_) return is_set_;
  if (const auto reason = request_()) {
    is_set_ = true;
    if (tell_) tell_(fmt::format("{}: stopping", *reason));
  }
  return is_set_;
}

}  // namespace crackle::ensemble
