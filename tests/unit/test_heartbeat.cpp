// SPDX-License-Identifier: GPL-3.0-or-later
#include "common/heartbeat.h"

#include <gmock/gmock.h>

#include <chrono>
#include <mutex>
#include <stdexcept>
#include <string>
#include <thread>
#include <vector>

namespace crackle {
namespace CRACKLE_TEST_FILE {

using namespace std::chrono_literals;
using ::testing::IsEmpty;
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
  /// Works on slow machines.
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
    lines.wait_for(n + 2);  // one may have been written before
  }
  EXPECT_THAT(lines.all().front(), StartsWith("placing points: "));
  EXPECT_THAT(lines.all().back(), StartsWith("solving: "));
}

TEST(Heartbeat, IsSilentBeforeAnythingBegins) {
  Lines lines;
  {
    const Heartbeat heartbeat(lines.collector(), 1ms);
    std::this_thread::sleep_for(50ms);
  }
  EXPECT_THAT(lines.all(), IsEmpty());
}

TEST(Heartbeat, WaitsAfterWhatIsSaidBesides) {
  Lines lines;
  {
    Heartbeat heartbeat(lines.collector(), 2s);
    heartbeat.begin("placing points");
    for (int i = 0; i < 25; ++i) {  // longer than the interval in total
      heartbeat.say("2 of 20 samples");
      std::this_thread::sleep_for(100ms);
    }
  }
  EXPECT_THAT(lines.all(), SizeIs(25));
}

TEST(Heartbeat, EndsWhereNobodyCanHearIt) {
  int n_tried = 0;
  Heartbeat heartbeat(
      [&](const std::string&) {
        ++n_tried;
        throw std::runtime_error("standard error is closed");
      },
      1ms);
  heartbeat.begin("placing points");
  std::this_thread::sleep_for(50ms);
  EXPECT_LE(n_tried, 1);
}

TEST(Heartbeat, NeedsNobodyToTalkTo) {
  Heartbeat heartbeat({}, 1ms);
  heartbeat.begin("placing points");
  heartbeat.say("nobody hears this");
}

}  // namespace CRACKLE_TEST_FILE
}  // namespace crackle
