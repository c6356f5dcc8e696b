// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <chrono>
#include <condition_variable>
#include <functional>
#include <mutex>
#include <string>
#include <thread>

namespace crackle {

/// Keeps long work from being silent: as long as it lives, a line every so often says what is going on and
/// for how long, unless something else was said meanwhile.
class Heartbeat {
public:
  using Say = std::function<void(const std::string& line)>;

  /// @param say called from a thread of the object's own too, never twice at a time; may be empty
  explicit Heartbeat(Say say, std::chrono::milliseconds interval = std::chrono::seconds(10));
  ~Heartbeat();
  Heartbeat(const Heartbeat&) = delete;
  Heartbeat& operator=(const Heartbeat&) = delete;

  /// What goes on from now on, such as "placing the mother points".
  void begin(const std::string& work);
  /// Says a line, and is silent for the next interval.
  void say(const std::string& line);

private:
  void beat(const std::stop_token& stop);

  using Clock = std::chrono::steady_clock;
  Say say_;
  std::chrono::milliseconds interval_;
  std::mutex mutex_;
  std::condition_variable_any changes_;
  std::string work_;  ///< empty before begin()
  Clock::time_point began_ = Clock::now();
  Clock::time_point spoke_ = began_;
  std::jthread thread_;  ///< the last member: it uses the others
};

}  // namespace crackle
