// SPDX-License-Identifier: GPL-3.0-or-later
#include "common/text_table.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

namespace crackle {

std::string aligned(const TextTable& table, std::size_t n_left, bool is_last_left) {
  std::vector<std::size_t> width(table.empty() ? 0 : table.front().size());
  for (const auto& row : table)
    for (std::size_t c = 0; c < row.size(); ++c) width[c] = std::max(width[c], row[c].size());
  std::string text;
  for (const auto& row : table) {
    std::string line;
    for (std::size_t c = 0; c < row.size(); ++c) {
      if (c > 0) line += "  ";
      const bool is_left = c < n_left || (is_last_left && c + 1 == row.size());
      line += is_left ? fmt::format("{:<{}}", row[c], width[c]) : fmt::format("{:>{}}", row[c], width[c]);
    }
    line.erase(line.find_last_not_of(' ') + 1);
    text += line + "\n";
  }
  return text;
}

std::string aligned(const std::vector<NamedValue>& lines, const char* between) {
  std::size_t width = 0;
  for (const auto& [name, value] : lines) width = std::max(width, name.size());
  std::string text;
  for (const auto& [name, value] : lines) text += fmt::format("{:<{}}{}{}\n", name, width, between, value);
  return text;
}

std::string shown(double value, const std::string& format, double factor) {
  return std::isnan(value) ? "-" : fmt::format(fmt::runtime(fmt::format("{{:{}}}", format)), factor * value);
}

std::string shown_range(double lower, double upper, const std::string& format, double factor) {
  if (std::isnan(lower) || std::isnan(upper)) return "-";
  return fmt::format("{} to {}", shown(lower, format, factor), shown(upper, format, factor));
}

std::string shown_percent(double share) {
  return std::isnan(share) ? "-" : fmt::format("{:.0f} %", 100 * share);
}

std::string shown_probability(double probability) {
  if (std::isnan(probability)) return "-";
  return probability < 0.001 ? "< 0.001" : fmt::format("{:.3f}", probability);
}

std::string with_unit(const std::string& label, const std::string& unit) {
  return unit.empty() ? label : fmt::format("{} [{}]", label, unit);
}

std::string duration_text(double seconds) {
  if (seconds > 0 && seconds < 10) return fmt::format("{:.2g} s", seconds);
  const auto total = std::llround(std::max(seconds, 0.0));
  const auto days = total / 86400, hours = total / 3600 % 24, minutes = total / 60 % 60;
  if (days > 0) return fmt::format("{} d {} h", days, hours);
  if (hours > 0) return fmt::format("{} h {} min", hours, minutes);
  if (minutes > 0) return fmt::format("{} min {} s", minutes, total % 60);
  return fmt::format("{} s", total);
}

}  // namespace crackle
