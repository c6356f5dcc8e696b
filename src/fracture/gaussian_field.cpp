// SPDX-License-Identifier: GPL-3.0-or-later
#include "fracture/gaussian_field.h"

#include "common/vector.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>

namespace crackle::fracture {

namespace {

/// cos(2 pi x) to 1e-9 for |x| < 2^40, by operations that vectorize and round identically on every processor.
inline double cosine_of_turns(double x) {
  // Adding and subtracting 1.5 2^52 rounds to the nearest integer.
  constexpr double rounder = 0x1.8p52;
  const double rest = x - ((x + rounder) - rounder);  // in [-1/2, 1/2]
  const double y = rest * rest;
  // Taylor series at 0, up to (2 pi x)^22.
  constexpr std::array<double, 12> coefficient = [] {
    std::array<double, 12> c{};
    double term = 1;
    for (std::size_t k = 0; k < c.size(); ++k) {
      c[k] = term;
      const double n = 2 * static_cast<double>(k);
      term *= -4 * std::numbers::pi * std::numbers::pi / ((n + 1) * (n + 2));
    }
    return c;
  }();
  double sum = coefficient.back();
  for (std::size_t k = coefficient.size() - 1; k-- > 0;) sum = sum * y + coefficient[k];
  return sum;
}

/// In (0, 1).
double inner_uniform(RandomStream& stream) {
  return stream.uniform() + 0x1p-54;
}

/// Two independent standard normal numbers (Box-Muller).
std::array<double, 2> normals(RandomStream& stream) {
  const double radius = std::sqrt(-2 * std::log(inner_uniform(stream)));
  const double turn = stream.uniform();
  return {radius * cosine_of_turns(turn), radius * cosine_of_turns(turn - 0.25)};
}

}  // namespace

GaussianField::GaussianField(RandomStream stream, double correlation_length, int n_waves) {
  const double scale = 1 / (2 * std::numbers::pi * correlation_length);
  for (int i = 0; i < n_waves; ++i) {
    RandomStream own = stream.substream(static_cast<std::uint64_t>(i));
    // The Matern spectrum is that of a normal vector over the root of a chi-square, each with 3 degrees of
    // freedom (Student's distribution in three dimensions).
    std::array<double, 6> normal{};
    for (std::size_t k = 0; k < 6; k += 2) {
      const auto pair = normals(own);
      normal[k] = pair[0];
      normal[k + 1] = pair[1];
    }
    const Vector direction{normal[0], normal[1], normal[2]};
    const Vector rest{normal[3], normal[4], normal[5]};
    const double amplitude = std::sqrt(-2 * std::log(inner_uniform(own)) / n_waves);
    waves_.push_back({scale * std::sqrt(3.0) / norm(rest) * direction, own.uniform(), amplitude});
  }
}

std::vector<double> GaussianField::at(std::span<const geometry::Point> points) const {
  constexpr std::size_t block = 64;
  std::vector<double> values(points.size(), 0);
  std::array<std::array<double, block>, 3> x{};
  std::array<double, block> sum{};
  for (std::size_t first = 0; first < points.size(); first += block) {
    const std::size_t n = std::min(block, points.size() - first);
    for (std::size_t i = 0; i < n; ++i)
      for (std::size_t axis = 0; axis < 3; ++axis) x[axis][i] = points[first + i][axis];
    sum.fill(0);
    for (const Wave& wave : waves_) {
      for (std::size_t i = 0; i < block; ++i) {
        const double turns = wave.turns[0] * x[0][i] + wave.turns[1] * x[1][i] + wave.turns[2] * x[2][i];
        sum[i] += wave.amplitude * cosine_of_turns(turns + wave.phase);
      }
    }
    std::copy_n(sum.begin(), n, values.begin() + static_cast<std::ptrdiff_t>(first));
  }
  return values;
}

double matern_correlation(double distance, double correlation_length) {
  const double s = std::sqrt(3.0) * distance / correlation_length;
  return (1 + s) * std::exp(-s);
}

}  // namespace crackle::fracture
