// SPDX-License-Identifier: GPL-3.0-or-later
// The template written by `crackle init`: the original input, with every other key as a comment.
#include "input/reader.h"

#include <gmock/gmock.h>

#include <filesystem>
#include <fstream>
#include <iterator>
#include <regex>
#include <sstream>
#include <string>

namespace crackle::input {
namespace CRACKLE_TEST_FILE {

using ::testing::HasSubstr;
using ::testing::Not;

std::string text_of(const std::string& job) {
  std::ifstream file(std::filesystem::path(CRACKLE_SOURCE_DIR) / "jobs" / job);
  return {std::istreambuf_iterator<char>(file), {}};
}

TEST(InputTemplate, IsTheInputItIsMadeFrom) {
  for (const char* const job : {"demo.toml", "paper.toml", "your-own-problem.toml", "gallery/ring.toml",
                                "gallery/offset-notch.toml"}) {
    const std::string text = text_of(job);
    EXPECT_EQ(echo(parse(annotated(text), job)), echo(parse(text, job))) << job;
  }
}

TEST(InputTemplate, ExplainsEveryKeyAndGivesItAValueOfTheRightForm) {
  const std::string text = annotated(text_of("demo.toml"));
  // Lines such as "- `x`, `y` (required): ...".
  std::istringstream lines(key_list());
  int n_keys = 0;
  for (std::string line; std::getline(lines, line);) {
    if (!line.starts_with("- ")) continue;
    const std::string names = line.substr(0, line.find(" ("));
    const std::regex name("[a-z_.]+");
    for (std::sregex_iterator found(names.begin(), names.end(), name); found != std::sregex_iterator();
         ++found, ++n_keys)
      EXPECT_TRUE(std::regex_search(text, std::regex("(^|\n)#?" + found->str() + " *= *[^ \n]"))) << line;
  }
  EXPECT_GT(n_keys, 70);
  const std::string all = std::regex_replace(text, std::regex("\n#([a-z_.]+ =|\\[)"), "\n$1");
  try {
    parse(all, "all.toml");
    FAIL() << "keys that exclude each other were accepted";
  } catch (const InputError& error) {
    // The remaining errors are contradictions, not names or types.
    for (const std::string& message : error.messages()) std::printf("%s\n", message.c_str());
    EXPECT_THAT(error.what(), Not(HasSubstr("unknown")));
    EXPECT_THAT(error.what(), Not(HasSubstr("expected")));
  }
}

TEST(InputTemplate, KeepsWhatTheInputSays) {
  const std::string text = annotated(text_of("your-own-problem.toml"));
  EXPECT_THAT(text, HasSubstr("at = \"30 mm\"                            # z of its mid-plane\n"));
  EXPECT_THAT(text,
              HasSubstr("\n# sample i, with its random fields and inputs, depends on (seed, i) only: "));
  EXPECT_THAT(text, HasSubstr("\n#seed = 0\n"));
  EXPECT_THAT(text, HasSubstr("\n#[[specimen.hole]]\n"));
}

}  // namespace CRACKLE_TEST_FILE
}  // namespace crackle::input
