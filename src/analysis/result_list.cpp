// SPDX-License-Identifier: GPL-3.0-or-later
#include "analysis/result_list.h"

#include <fmt/format.h>

#include <algorithm>
#include <charconv>
#include <cmath>
#include <iterator>
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

std::string shown(const Observation& one, const std::string& format, double factor) {
  return (one.is_bound ? "> " : "") + shown(one.value, format, factor);
}

std::string fitting_format(const std::string& format, std::span<const Observation> values, double factor) {
  if (!format.ends_with('f')) return format;
  std::vector<double> sorted;
  for (const Observation& one : values)
    if (std::isfinite(one.value)) sorted.push_back(factor * one.value);
  if (sorted.empty()) return format;
  std::ranges::sort(sorted);
  const std::size_t n = sorted.size();
  // Of the middle half, so that a single far value does not hide it.
  double scatter = sorted[3 * n / 4] - sorted[n / 4];
  if (scatter == 0) scatter = sorted.back() - sorted.front();
  const double size = std::max(std::abs(sorted.front()), std::abs(sorted.back()));
  if (size == 0) return format;
  const auto leading = [](double value) { return static_cast<int>(std::floor(std::log10(value))); };
  // Rounding is no scatter.
  const int decimals = scatter > 1e-9 * size ? 2 - leading(scatter) : 4 - leading(size);
  const int most = std::stoi(format.substr(1));
  return fmt::format(".{}f", std::clamp(decimals, 0, most));
}

}  // namespace crackle::analysis
