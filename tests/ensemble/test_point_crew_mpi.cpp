// SPDX-License-Identifier: GPL-3.0-or-later
// Ranks that place mother points together.
#include "ensemble/point_crew.h"
#include "geometry/body.h"
#include "geometry/mother_points.h"
#include "parallel/agreement.h"
#include "parallel/collectives.h"

#include "support/group.h"

#include <gmock/gmock.h>

#include <stdexcept>
#include <string>

namespace crackle::ensemble {
namespace CRACKLE_TEST_FILE {

using geometry::MotherPoints;
using ::testing::HasSubstr;

/// A plate whose faces and interior each have enough points to share, with spacings from 0.2 to 0.4 mm.
class PointCrewTest : public testing::Test {
protected:
  PointCrewTest() {
    mesh_.spacing = mesh_.notch_spacing = 0.4e-3;
    mesh_.growth = 0.05;
    mesh_.min_quality = 0.2;
    mesh_.regions.push_back({{{{0, 1.2e-3}, {2e-3, 3e-3}, {15e-3, 16e-3}}}, 0.2e-3});
  }

  MotherPoints make(std::uint64_t seed, geometry::Crew* crew) const {
    return geometry::make_mother_points(body_, mesh_, seed, {}, 0, 0, crew);
  }
  /// @param failing seed of the points for which the last rank fails instead of helping
  auto helping(PointCrew& crew, std::uint64_t failing) {
    return [this, &crew, failing](const PointTask& task, std::vector<input::MeshRegion> regions) {
      if (task.subject == failing && crew.rank() == crew.size() - 1) throw std::runtime_error("no help");
      input::Mesh mesh = mesh_;
      mesh.regions = std::move(regions);
      geometry::help_mother_points(body_, mesh, task.subject, 0, 0, crew);
    };
  }
  auto helping(std::uint64_t failing = 0) { return helping(crew_, failing); }

  parallel::Communicator world_{test::group()};
  PointCrew crew_{world_};
  const geometry::Body body_ = *geometry::make_body(plane::Specimen{{1.2e-3, 18e-3, 18e-3}, {}});
  input::Mesh mesh_;
};

TEST_F(PointCrewTest, PlacesTheSamePointsOnAnyNumberOfRanks) {
  std::vector<MotherPoints> made;
  crew_.agree_on_root(
      [&] {
        for (const std::uint64_t seed : {1, 2}) made.push_back(make(seed, crew_.for_task({.subject = seed})));
      },
      helping());
  if (!world_.is_root()) return;
  for (const std::uint64_t seed : {1, 2}) {
    const MotherPoints& alone = test::reference([&] { return make(seed, nullptr); });
    EXPECT_GT(alone.size(), 10000u);
    EXPECT_EQ(made[seed - 1].position, alone.position);
    EXPECT_EQ(made[seed - 1].spacing, alone.spacing);
  }
}

TEST_F(PointCrewTest, OthersThanTheFirstRanksDoNotPlacePoints) {
  if (world_.size() < 3) GTEST_SKIP() << "needs 3 ranks";
  PointCrew two(world_, 2);
  int n_helped = 0;
  const auto help = [&](const PointTask& task, std::vector<input::MeshRegion> regions) {
    ++n_helped;
    helping(two, 4)(task, std::move(regions));
  };
  two.agree_on_root([&] { EXPECT_GT(make(1, two.for_task({.subject = 1})).size(), 10000u); }, help);
  EXPECT_EQ(n_helped, world_.rank() == 1 ? 1 : 0);
  EXPECT_THAT([&] { two.agree_on_root([&] { make(4, two.for_task({.subject = 4})); }, help); },
              testing::ThrowsMessage<parallel::AgreedError>(HasSubstr("no help")))
      << "on all ranks";
}

TEST_F(PointCrewTest, AFailureOfAnyRankIsThrownOnAll) {
  if (world_.size() == 1) GTEST_SKIP() << "needs 2 ranks";
  const auto place = [&] { make(3, crew_.for_task({.subject = 3})); };
  EXPECT_THAT([&] { crew_.agree_on_root(place, helping(3)); },
              testing::ThrowsMessage<parallel::AgreedError>(HasSubstr("no help")));
  const auto fail_later = [&] {
    place();
    throw std::runtime_error("no room");
  };
  EXPECT_THAT([&] { crew_.agree_on_root(fail_later, helping()); },
              testing::ThrowsMessage<parallel::AgreedError>(HasSubstr("no room")));
  EXPECT_EQ(parallel::share(world_, world_.is_root() ? 5 : 0), 5) << "no message is left over";
}

}  // namespace CRACKLE_TEST_FILE
}  // namespace crackle::ensemble
