// SPDX-License-Identifier: GPL-3.0-or-later
#include "factor_integral.h"

namespace crackle::mechanics {

namespace {

/// A part of a segment or triangle.
template <std::size_t n>
struct Part {
  std::array<std::array<double, n>, n> shape;  ///< the shape functions at each of its corners
  std::array<double, n> coordinate;            ///< of its corners, along the factor's axis
  double measure;
};

/// Cuts a part in two where one of its edges crosses a coordinate. @return false if none does
template <std::size_t n>
bool cut(const Part<n>& part, double at, Part<n>& below, Part<n>& above) {
  for (std::size_t i = 0; i < n; ++i)
    for (std::size_t j = 0; j < n; ++j) {
      if (!(part.coordinate[i] < at && at < part.coordinate[j])) continue;
      const double share = (at - part.coordinate[i]) / (part.coordinate[j] - part.coordinate[i]);
      below = above = part;
      for (std::size_t a = 0; a < n; ++a)
        below.shape[j][a] = above.shape[i][a] =
            part.shape[i][a] + share * (part.shape[j][a] - part.shape[i][a]);
      below.coordinate[j] = above.coordinate[i] = at;
      below.measure = share * part.measure;
      above.measure = (1 - share) * part.measure;
      return true;
    }
  return false;
}

/// @param kink first entry of the factor's table that may lie inside the part
template <std::size_t n>
void add(const input::Profile& factor, const Part<n>& part, std::size_t kink, std::array<double, n>& sum) {
  for (; kink < factor.table.size(); ++kink) {
    Part<n> below, above;
    if (!cut(part, factor.table[kink].first, below, above)) continue;
    add(factor, below, kink, sum);
    add(factor, above, kink, sum);
    return;
  }
  // The integral of the product of two linear functions, from their values at the corners.
  for (std::size_t i = 0; i < n; ++i)
    for (std::size_t j = 0; j < n; ++j) {
      const double weight = part.measure * (i == j ? 2 : 1) / static_cast<double>(n * (n + 1));
      for (std::size_t a = 0; a < n; ++a) sum[a] += weight * factor.at(part.coordinate[i]) * part.shape[j][a];
    }
}

}  // namespace

template <std::size_t n>
std::array<double, n> factor_shares(const input::Profile& factor, const std::array<Vector, n>& corners,
                                    double measure) {
  Part<n> whole{};
  whole.measure = measure;
  for (std::size_t i = 0; i < n; ++i) {
    whole.shape[i][i] = 1;
    whole.coordinate[i] = corners[i][factor.axis];
  }
  std::array<double, n> sum{};
  add(factor, whole, 0, sum);
  return sum;
}

template std::array<double, 2> factor_shares(const input::Profile&, const std::array<Vector, 2>&, double);
template std::array<double, 3> factor_shares(const input::Profile&, const std::array<Vector, 3>&, double);

}  // namespace crackle::mechanics
