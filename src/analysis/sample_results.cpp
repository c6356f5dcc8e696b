// SPDX-License-Identifier: GPL-3.0-or-later
#include "crackle/analysis/sample_results.h"

#include <fmt/format.h>

#include <charconv>
#include <iterator>
#include <string_view>
#include <utility>
#include <vector>

namespace crackle::analysis {

namespace {

std::vector<std::pair<std::int64_t, std::string_view>> words_of(std::string_view categories) {
  std::vector<std::pair<std::int64_t, std::string_view>> words;
  while (!categories.empty()) {
    const auto end = categories.find(", ");
    const std::string_view entry = categories.substr(0, end);
    categories = end == std::string_view::npos ? std::string_view() : categories.substr(end + 2);
    std::int64_t number = 0;
    const auto [rest, error] = std::from_chars(entry.data(), entry.data() + entry.size(), number);
    if (error == std::errc())
      words.emplace_back(number, entry.substr(static_cast<std::size_t>(rest - entry.data()) + 1));
  }
  return words;
}

}  // namespace

std::string category_name(const char* categories, std::int64_t value) {
  for (const auto& [number, word] : words_of(categories))
    if (number == value) return std::string(word);
  return fmt::format("{}", value);
}

int n_categories(const char* categories) {
  return static_cast<int>(words_of(categories).size());
}

std::string result_table() {
  std::string text = "| dataset | shape | meaning |\n|---|---|---|\n";
  const auto add = [&](const char* group, const char* shape, const ResultInfo& info) {
    std::string meaning = info.meaning;
    if (*info.categories != 0) meaning += fmt::format(": {}", info.categories);
    if (*info.units != 0 && std::string_view(info.units) != "1") meaning += fmt::format(" [{}]", info.units);
    fmt::format_to(std::back_inserter(text), "| `/{}/{}` | {} | {} |\n", group, info.name, shape, meaning);
  };
  for_each_result([&](const ResultInfo& info, auto) { add("samples", "N", info); });
  add("samples", "N × P", crack_area_in_info);
  for_each_position_result([&](const ResultInfo& info, auto) { add("crack_path", "N × K × S", info); });
  return text;
}

}  // namespace crackle::analysis
