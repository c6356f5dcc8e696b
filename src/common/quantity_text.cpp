// SPDX-License-Identifier: GPL-3.0-or-later
#include "common/quantity_text.h"

#include <fmt/format.h>

#include <array>
#include <cctype>
#include <charconv>
#include <cmath>
#include <utility>

namespace crackle {

namespace {

/// Columns with larger values get another unit.
constexpr double greatest_shown = 1e6;
/// Magnitudes that need no prefix in a sentence.
constexpr double least_plain = 0.1, greatest_plain = 1e4;

constexpr std::array<std::pair<std::string_view, double>, 9> prefixes{{{"p", 1e-12},
                                                                       {"n", 1e-9},
                                                                       {"u", 1e-6},
                                                                       {"m", 1e-3},
                                                                       {"", 1},
                                                                       {"k", 1e3},
                                                                       {"M", 1e6},
                                                                       {"G", 1e9},
                                                                       {"T", 1e12}}};

/// Power of the leading symbol of a unit: 2 for "m^2".
int power_of_symbol(const std::string& si) {
  std::size_t end = 0;
  while (end < si.size() && std::isalpha(static_cast<unsigned char>(si[end])) != 0) ++end;
  return end + 1 < si.size() && si[end] == '^' ? si[end + 1] - '0' : 1;
}

/// The unit with the prefix that brings the magnitude to 1 or slightly more.
ShownUnit prefixed(const std::string& si, double magnitude) {
  const int power = power_of_symbol(si);
  const double least = power > 1 ? 0.01 : 1;  // prefixes of areas are a million apart
  ShownUnit best;
  for (const auto& [prefix, size] : prefixes) {
    const double factor = std::pow(size, -power);
    // The first that fits, then larger ones as long as they show enough digits; ks and km are not in use.
    if (size > 1 && (si[0] == 's' || si[0] == 'm')) break;
    if (best.name.empty() || magnitude * factor >= least) best = {std::string(prefix) + si, factor};
  }
  return best;
}

bool has_size(double magnitude) {
  return magnitude > 0 && std::isfinite(magnitude);
}

}  // namespace

ShownUnit shown_unit(const ShownUnit& usual, const std::string& si, double largest, double least) {
  const double shown = largest * usual.factor;
  if (si.empty() || si == "1" || !has_size(largest) || (shown >= least && shown < greatest_shown))
    return usual;
  return prefixed(si, largest);
}

std::string quantity_text(double value, const std::string& si, int n_digits) {
  return quantity_text(value, si, n_digits, value);
}

std::string quantity_text(double value, const std::string& si, int n_digits, double largest) {
  const double magnitude = std::abs(largest);
  const bool is_plain = !has_size(magnitude) || (magnitude >= least_plain && magnitude < greatest_plain);
  const bool is_of_millimetres = si == "m" && (magnitude == 0 || (magnitude >= 1e-5 && magnitude < 1));
  const ShownUnit unit = is_of_millimetres ? ShownUnit{"mm", 1e3}
                         : is_plain        ? ShownUnit{si, 1}
                                           : prefixed(si, magnitude);
  // More digits if there is no suitable prefix.
  return fmt::format("{:.{}g} {}", value * unit.factor,
                     std::abs(value) * unit.factor < greatest_plain ? n_digits : 6, unit.name);
}

double to_six_digits(double value) {
  const std::string text = fmt::format("{:.6g}", value);
  double result = value;
  std::from_chars(text.data(), text.data() + text.size(), result);
  return result;
}

std::string count_text(std::int64_t n, std::string_view noun) {
  return fmt::format("{} {}{}", n, noun, n == 1 ? "" : "s");
}

}  // namespace crackle
