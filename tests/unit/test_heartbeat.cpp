// SPDX-License-Identifier: GPL-3.0-or-later
#include "crackle/common/heartbeat.h"

#include <gmock/gmock.h>

#include <chrono>
#include <mutex>
#include <string>
#include <thread>
#include <vector>

namespace crackle {
namespace {

using namespace std::chrono_literals;
using ::testing::SizeIs;
using ::testing::StartsWith;

class Lines {
public:
  Heartbeat::Say collector() {
    return [this](const std::string& line) {
      const std::lock_guard lock(mutex_);
      lines_.push_back(line);
    };
  }
  std::vector<std::string> all() {
    const std::lock_guard lock(mutex_);
    return lines_;
  }
  /// However slow the machine is.
  void wait_for(std::size_t n) {
    while (all().size() < n) std::this_thread::sleep_for(1ms);
  }

private:
  std::mutex mutex_;
  std::vector<std::string> lines_;
};

TEST(Heartbeat, SaysAgainAndAgainWhatGoesOn) {
  Lines lines;
  {
    Heartbeat heartbeat(lines.collector(), 2ms);
    heartbeat.begin("placing points");
    lines.wait_for(2);
    heartbeat.begin("solving");
    const auto n = lines.all().size();
    lines.wait_for(n + 2);  // one may have been said before
  }
  EXPECT_THAT(lines.all().front(), StartsWith("placing points: "));
  EXPECT_THAT(lines.all().back(), StartsWith("solving: "));
}

TEST(Heartbeat, IsSilentBeforeAnythingBeginsAndBesideOtherLines) {
  Lines lines;
  {
    Heartbeat heartbeat(lines.collector(), 1h);
    heartbeat.begin("placing points");
    heartbeat.say("2 of 20 samples");
  }
  EXPECT_THAT(lines.all(), SizeIs(1));
}

TEST(Heartbeat, NeedsNobodyToTalkTo) {
  Heartbeat heartbeat({}, 1ms);
  heartbeat.begin("placing points");
  heartbeat.say("nobody hears this");
}

}  // namespace
}  // namespace crackle
