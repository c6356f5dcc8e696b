// SPDX-License-Identifier: GPL-3.0-or-later
#include "common/heartbeat.h"

#include <fmt/format.h>

#include <utility>

namespace crackle {

Heartbeat::Heartbeat(Say say, std::chrono::milliseconds interval)
    : say_(std::move(say)), interval_(interval) {
  if (say_) thread_ = std::jthread([this](const std::stop_token& stop) { beat(stop); });
}

Heartbeat::~Heartbeat() = default;

void Heartbeat::begin(const std::string& work) {
  const std::lock_guard lock(mutex_);
  if (work == work_) return;
  work_ = work;
  began_ = Clock::now();
}

void Heartbeat::say(const std::string& line) {
  const std::lock_guard lock(mutex_);
  spoke_ = Clock::now();
  if (say_) say_(line);
}

void Heartbeat::beat(const std::stop_token& stop) {
  std::unique_lock lock(mutex_);
  while (!stop.stop_requested()) {
    const auto due = spoke_ + interval_;
    changes_.wait_until(lock, stop, due, [&] { return stop.stop_requested(); });
    const auto now = Clock::now();
    if (stop.stop_requested() || now < spoke_ + interval_) continue;
    spoke_ = now;
    if (work_.empty()) continue;
    try {
      say_(fmt::format("{}: {:.3g} s so far", work_, std::chrono::duration<double>(now - began_).count()));
    } catch (...) {
      return;  // the output is broken; the next writer will report the failure
    }
  }
}

}  // namespace crackle
