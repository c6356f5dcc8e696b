// SPDX-License-Identifier: GPL-3.0-or-later
#include "crackle/ensemble/base_points.h"

#include <gtest/gtest.h>

#include <stdexcept>
#include <string>

namespace crackle::ensemble {
namespace {

TEST(BasePoints, LongWaitIsTold) {
  EXPECT_EQ(waiting_notice(763e3), "placing some 0.76 million mother points takes about 34 s");
  EXPECT_EQ(waiting_notice(2e7), "placing some 20 million mother points takes about 15 min 0 s");
  EXPECT_EQ(waiting_notice(54695), "");
}

TEST(BasePoints, WaitIsToldBeforeIt) {
  input::Parameters parameters;
  parameters.specimen.size = {0.1, 0.1, 0.1};
  parameters.mesh.spacing = parameters.mesh.notch_spacing = 1e-3;
  std::string heard;
  const auto stop_there = [&](const std::string& line) {
    heard = line;
    throw std::runtime_error("heard");
  };
  EXPECT_THROW(make_base_points(geometry::Body(parameters.specimen), parameters, stop_there),
               std::runtime_error);
  EXPECT_EQ(heard.substr(0, 15), "placing some 1.") << heard;
}

TEST(BasePoints, NoWaitIsToldOfWhatIsRefused) {
  input::Parameters parameters;
  parameters.specimen.size = {0.1, 0.1, 0.1};
  parameters.mesh.spacing = parameters.mesh.notch_spacing = 1e-4;
  std::string heard;
  EXPECT_THROW(make_base_points(geometry::Body(parameters.specimen), parameters,
                                [&](const std::string& line) { heard = line; }),
               std::runtime_error);
  EXPECT_EQ(heard, "");
}

}  // namespace
}  // namespace crackle::ensemble
