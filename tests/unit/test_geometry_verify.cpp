// SPDX-License-Identifier: GPL-3.0-or-later
// Deliberately broken realizations: each must be rejected for the right reason.
#include "geometry/quality.h"
#include "geometry/realization.h"
#include "support/geometry_bodies.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

namespace crackle::geometry {
namespace CRACKLE_TEST_FILE {

using ::testing::HasSubstr;
using ::testing::ThrowsMessage;

std::size_t index(std::int32_t i) {
  return static_cast<std::size_t>(i);
}

class Verify : public ::testing::Test {
protected:
  static void SetUpTestSuite() {
    const Body plate = testing::short_plate();
    const MotherPoints base = make_mother_points(plate, testing::plate_mesh(), 2012);
    whole_ = new Realization(make_realization(plate, base, testing::plate_mesh(), 2012, 0));
  }
  static void TearDownTestSuite() { delete whole_; }
  void SetUp() override { broken = *whole_; }

  void expect(const char* reason, double min_quality = 0.2) const {
    EXPECT_THAT([&] { verify(broken, plate, min_quality); },
                ThrowsMessage<std::runtime_error>(HasSubstr(reason)));
  }
  /// A node with these movable axes.
  std::size_t node_with(std::uint8_t movable) const {
    const auto found = std::find_if(broken.nodes.begin(), broken.nodes.end(),
                                    [&](const Point& p) { return plate.movable(p) == movable; });
    EXPECT_NE(found, broken.nodes.end());
    return static_cast<std::size_t>(found - broken.nodes.begin());
  }
  /// A tetrahedron with no node on the surface.
  std::size_t inner_tetrahedron() const {
    const auto found =
        std::find_if(broken.tetrahedra.begin(), broken.tetrahedra.end(), [&](const Tetrahedron& t) {
          return std::all_of(t.begin(), t.end(), [&](std::int32_t node) {
            return plate.movable(broken.nodes[index(node)]) == 7;
          });
        });
    return static_cast<std::size_t>(found - broken.tetrahedra.begin());
  }

  const Body plate = testing::short_plate();
  Realization broken;

private:
  static inline Realization* whole_ = nullptr;
};

TEST_F(Verify, AcceptsTheWholeOne) {
  EXPECT_GE(verify(broken, plate, 0.2), 0.2);
  EXPECT_DOUBLE_EQ(verify(broken, plate, 0.2), broken.report.min_quality);
}

TEST_F(Verify, MissingTetrahedron) {
  broken.tetrahedra.erase(broken.tetrahedra.begin() + static_cast<std::ptrdiff_t>(inner_tetrahedron()));
  expect("the tetrahedra have the volume");
}

// Adding the hole's surface as boundary does not help.
TEST_F(Verify, TetrahedronTwiceInsteadOfAnother) {
  broken.tetrahedra[inner_tetrahedron() + 1] = broken.tetrahedra[inner_tetrahedron()];
  EXPECT_THROW(verify(broken, plate, 0.2), std::runtime_error);
}

TEST_F(Verify, InvertedTetrahedron) {
  std::swap(broken.tetrahedra[7][2], broken.tetrahedra[7][3]);
  expect("tetrahedron 7 has the volume -");
}

TEST_F(Verify, LowQuality) {
  expect("below min_quality = 0.9", 0.9);
}

TEST_F(Verify, BoundaryNodeOffItsPlaneByOneBit) {
  for (const std::uint8_t movable : {6, 5, 3}) {
    SetUp();
    const std::size_t node = node_with(movable);
    for (std::size_t i = 0; i < 3; ++i)
      if (!((movable >> i) & 1u))
        broken.nodes[node][i] = std::nextafter(broken.nodes[node][i], 0.5 * plate.size()[i]);
    expect("does not lie exactly on surface");
  }
}

TEST_F(Verify, BoundaryNodeMovedIntoTheBody) {
  const std::size_t node = node_with(6);
  broken.nodes[node][0] += (broken.nodes[node][0] == 0 ? 1 : -1) * 1e-5;
  expect("the tetrahedra have the volume");
}

TEST_F(Verify, TetrahedronAcrossANotch) {
  const testing::SlotFaces slot = testing::slot_faces(plate, 0);
  std::vector<std::int32_t> lower;
  std::vector<std::int32_t> upper;
  for (std::size_t i = 0; i < broken.nodes.size(); ++i) {
    if (broken.nodes[i][1] > slot.tip) continue;
    if (broken.nodes[i][2] == slot.lower) lower.push_back(static_cast<std::int32_t>(i));
    if (broken.nodes[i][2] == slot.upper) upper.push_back(static_cast<std::int32_t>(i));
  }
  const auto volume = [&](const Tetrahedron& t) {
    return signed_volume(broken.nodes[index(t[0])], broken.nodes[index(t[1])], broken.nodes[index(t[2])],
                         broken.nodes[index(t[3])]);
  };
  // From wall to wall inside the slot, and from the material through one wall to the other.
  for (const std::int32_t first : {lower[0], static_cast<std::int32_t>(node_with(7))}) {
    SetUp();
    Tetrahedron across{first, lower[1], upper[0], upper[1]};
    for (std::size_t i = 2; volume(across) == 0; ++i) across[3] = upper[i];
    if (volume(across) < 0) std::swap(across[2], across[3]);
    broken.tetrahedra.push_back(across);
    expect("extends beyond the body", 0);
  }
}

TEST_F(Verify, NodesThatDoNotExistOrAreNotUsed) {
  broken.nodes.push_back({1e-3, 1e-3, 1e-3});
  expect("belongs to no tetrahedron");
  SetUp();
  broken.tetrahedra[3][2] = static_cast<std::int32_t>(broken.nodes.size());
  expect("tetrahedron 3 has the node");
  broken.tetrahedra[3][2] = -1;
  expect("tetrahedron 3 has the node -1");
}

TEST_F(Verify, BoundaryList) {
  broken.boundary.pop_back();
  expect("faces have only one tetrahedron");
  SetUp();
  std::swap(broken.boundary[5].nodes[1], broken.boundary[5].nodes[2]);
  expect("boundary triangle 5 is not the face");
  SetUp();
  std::swap(broken.boundary[5], broken.boundary[6]);
  expect("boundary triangle 5 is not the face");
  SetUp();
  broken.boundary[5].surface = 99;
  expect("boundary triangle 5 has the surface 99");
  SetUp();
  broken.boundary[5].surface = (broken.boundary[5].surface + 1) % 6;
  expect("does not lie exactly on surface");
}

// A body of another size: right nodes for the wrong body.
TEST_F(Verify, AnotherBody) {
  const Body longer = testing::body({3, 16, 24.000001}, {testing::notch(plane::Face::y_min, 9, 4, 0.6),
                                                         testing::notch(plane::Face::y_max, 15, 4, 0.6)});
  EXPECT_THAT([&] { verify(broken, longer, 0.2); }, ThrowsMessage<std::runtime_error>(HasSubstr("volume")));
  const Body without = testing::body({3, 16, 24});
  EXPECT_THROW(verify(broken, without, 0.2), std::runtime_error);
}

}  // namespace CRACKLE_TEST_FILE
}  // namespace crackle::geometry
