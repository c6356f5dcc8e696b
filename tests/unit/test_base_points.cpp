// SPDX-License-Identifier: GPL-3.0-or-later
#include "ensemble/base_points.h"
#include "geometry/body.h"

#include <gtest/gtest.h>

#include <stdexcept>
#include <string>

namespace crackle::ensemble {
namespace CRACKLE_TEST_FILE {

input::Parameters small_plate(input::Base base) {
  input::Parameters parameters;
  parameters.seed = 3;
  parameters.specimen.size = {2e-3, 6e-3, 8e-3};
  parameters.mesh.spacing = parameters.mesh.notch_spacing = 1e-3;
  parameters.mesh.min_quality = 0.1;
  parameters.mesh.base = base;
  return parameters;
}

TEST(BasePoints, AreSharedOrEachSamplesOwn) {
  const auto nodes = [](input::Base base, std::uint64_t sample, int attempt = 0) {
    const auto parameters = small_plate(base);  // unperturbed: the nodes are the base points
    const geometry::Body body = *geometry::make_body(parameters.specimen);
    const auto shared = make_shared_points(body, parameters.mesh, parameters.seed);
    EXPECT_EQ(shared.size() == 0, base == input::Base::own);
    return make_sample_mesh(body, shared, parameters.mesh, parameters.seed, sample, attempt).nodes;
  };
  EXPECT_EQ(nodes(input::Base::shared, 0), nodes(input::Base::shared, 1));
  const auto first = nodes(input::Base::own, 0);
  EXPECT_EQ(first, nodes(input::Base::own, 0));
  EXPECT_NE(first, nodes(input::Base::own, 1));
  EXPECT_NE(first, nodes(input::Base::own, 0, 1)) << "another attempt places other points";
  EXPECT_NE(first, nodes(input::Base::shared, 0));
  const auto parameters = small_plate(input::Base::own);
  EXPECT_EQ(
      make_base_points(*geometry::make_body(parameters), parameters.mesh, parameters.seed, {}, 1).position,
      nodes(input::Base::own, 1));
}

TEST(BasePoints, OfEachSampleAreRefusedBeforeAnySampleIsMade) {
  auto parameters = small_plate(input::Base::own);
  parameters.mesh.spacing = parameters.mesh.notch_spacing = 1e-6;
  EXPECT_THROW(make_shared_points(*geometry::make_body(parameters), parameters.mesh, parameters.seed),
               std::runtime_error);
}

}  // namespace CRACKLE_TEST_FILE
}  // namespace crackle::ensemble
