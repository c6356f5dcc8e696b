// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <chrono>
#include <condition_variable>
#include <functional>
#include <mutex>
#include <string>
#include <thread>

namespace crackle {

/// Reports long work at intervals during its lifetime: a line says what is going on and for how long, unless
/// something else was said recently.
class Heartbeat {
public:
  using Say = std::function<void(const std::string& line)>;

  /// @param say also called from the object's own thread, never concurrently; may be empty
  explicit Heartbeat(Say say, std::chrono::milliseconds interval = std::chrono::seconds(10));
  ~Heartbeat();
  Heartbeat(const Heartbeat&) = delete;
  Heartbeat& operator=(const Heartbeat&) = delete;

  /// Sets the current work, such as "placing the mother points".
  void begin(const std::string& work);
  /// Says a line, which restarts the interval.
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
  std::jthread thread_;  ///< last member, as it uses the others
};

}  // namespace crackle
