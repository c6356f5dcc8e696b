// SPDX-License-Identifier: GPL-3.0-or-later
#include "crackle/analysis/text_table.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

namespace crackle::analysis {

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

std::string shown(double value, const std::string& format, double factor) {
  return std::isnan(value) ? "-" : fmt::format(fmt::runtime(fmt::format("{{:{}}}", format)), factor * value);
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

}  // namespace crackle::analysis
