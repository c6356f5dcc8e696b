// SPDX-License-Identifier: GPL-3.0-or-later
#include "reflection.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>
#include <utility>

namespace crackle::geometry {

Point Reflection::operator()(const Point& p) const {
  Point q = p;
  for (std::size_t i = 0; i < 3; ++i) {
    if (!((axes >> i) & 1u)) continue;
    q[i] = box.upper[i] - p[i] + box.lower[i];
    const auto plane =
        std::ranges::find_if(planes[i], [&](double position) { return std::abs(position - q[i]) <= near; });
    if (plane != planes[i].end()) q[i] = *plane;
  }
  return q;
}

std::string Reflection::name() const {
  std::vector<char> names;
  for (unsigned i = 0; i < 3; ++i)
    if ((axes >> i) & 1u) names.push_back("xyz"[i]);
  return names.empty() ? "as it is" : fmt::format("reflected in the middle of {}", fmt::join(names, " and "));
}

Symmetry Reflection::symmetry(std::vector<std::int32_t> crack_start) const {
  const bool is_reflection = axes == 1 || axes == 2 || axes == 4 || axes == 7;
  return {static_cast<std::uint8_t>(axes), name(), is_reflection, *this, *this, std::move(crack_start)};
}

}  // namespace crackle::geometry
