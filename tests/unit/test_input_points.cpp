// SPDX-License-Identifier: GPL-3.0-or-later
// The contents of the file of mesh.points are part of the input.
#include "input_samples.h"
#include "support/temporary_folder.h"

#include <gmock/gmock.h>

#include <fstream>

namespace crackle::input {
namespace CRACKLE_TEST_FILE {

TEST(InputPoints, DigestFollowsTheContentNotTheName) {
  const test::TemporaryFolder folder;
  const auto write = [&](const char* name, const std::string& text) {
    std::ofstream(folder.path() / name, std::ios::binary) << text;
  };
  auto tables = test::minimal_tables();
  EXPECT_EQ(test::parse_tables(tables).mesh.points_digest, "");
  test::set_key(tables, "[mesh]", "points", R"("cloud.txt")");
  const std::string text = test::to_text(tables);
  const auto digest = [&](const std::filesystem::path& points = {}) {
    const Parameters parameters = parse(text, folder.path() / "plate.toml", {.points = points});
    EXPECT_EQ(parameters.mesh.points, points.empty() ? folder.path() / "cloud.txt" : points);
    return parameters.mesh.points_digest;
  };
  const std::string large(200'000, '7');
  write("cloud.txt", large + "1");
  write("same.txt", large + "1");
  const std::string first = digest();
  std::printf("%s\n", first.c_str());
  EXPECT_EQ(digest(folder.path() / "same.txt"), first);
  write("cloud.txt", large + "2");
  EXPECT_NE(digest(), first);
  // The published value of FNV-1a for "foobar".
  write("cloud.txt", "foobar");
  EXPECT_EQ(digest(), "6 bytes, FNV-1a 85944171f73967e8");

  std::filesystem::remove(folder.path() / "cloud.txt");
  EXPECT_THROW(digest(), InputError);
  EXPECT_EQ(digest(folder.path() / "same.txt"), first) << "the file named is not needed then";
  const GivenFiles known{.points = folder.path() / "nowhere.txt", .points_digest = first};
  const Parameters elsewhere = parse(text, folder.path() / "plate.toml", known);
  EXPECT_EQ(elsewhere.mesh.points, known.points);
  EXPECT_EQ(elsewhere.mesh.points_digest, first) << "no file is needed where its digest is known";
}

}  // namespace CRACKLE_TEST_FILE
}  // namespace crackle::input
