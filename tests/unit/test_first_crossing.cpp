// SPDX-License-Identifier: GPL-3.0-or-later
// Which tetrahedron first reaches its strength, for any order and distribution of tetrahedra.
#include "common/random.h"
#include "fracture/equivalent_stress.h"
#include "fracture/first_crossing.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>
#include <utility>
#include <vector>

namespace crackle::fracture {
namespace CRACKLE_TEST_FILE {

constexpr double infinity = std::numeric_limits<double>::infinity();
constexpr double strength = 35e6;
const LargestPrincipalStress of;

struct Loaded {
  mechanics::Symmetric stress, rate;
};

mechanics::Symmetric random_tensor(RandomStream& stream, double size) {
  mechanics::Symmetric tensor{};
  for (double& component : tensor) component = size * stream.uniform(-1, 1);
  return tensor;
}

/// Many that cross nearly at the same time, some practically at their strength, and some that do not cross.
std::vector<Loaded> loaded(std::uint64_t number, double spread) {
  auto stream = RandomStream(5, 0, "crossing").substream(number);
  std::vector<Loaded> all;
  while (all.size() < 200) {
    Loaded one{random_tensor(stream, 10e6), random_tensor(stream, 1e5)};
    if (all.size() % 10 == 9) {
      one.rate = random_tensor(stream, 1e3);
      for (std::size_t i = 0; i < 3; ++i) one.rate[i] = -std::abs(one.rate[i]);
      all.push_back(one);
      continue;
    }
    const double s = crossing(of, one.stress, one.rate, strength, infinity);
    if (std::isinf(s)) continue;
    for (double& component : one.rate) component *= s / (1000 * (1 + spread * stream.uniform(0, 1)));
    all.push_back(one);
  }
  return all;
}

FirstCrossing look(const std::vector<Loaded>& all, const std::vector<std::int64_t>& order, double limit) {
  FirstCrossing first(of, limit);
  for (const auto i : order)
    first.see(all[static_cast<std::size_t>(i)].stress, all[static_cast<std::size_t>(i)].rate, strength, i);
  return first;
}

/// The bits of the break time must not depend on which other tetrahedra the rank has seen before.
TEST(FirstCrossing, IsTheSameInEveryOrderAndShare) {
  int n_searched = 0;
  for (std::uint64_t number = 0; number < 17; ++number) {
    const double spread = std::pow(10.0, -static_cast<double>(number % 17));
    const auto all = loaded(number, spread);
    for (const double limit : {infinity, 1500.0, 1000.0 * (1 - 0.5 * spread), 900.0}) {
      std::vector<std::int64_t> order(all.size());
      std::iota(order.begin(), order.end(), 0);
      const FirstCrossing reference = look(all, order, limit);
      // Each searched for separately.
      double smallest = infinity;
      for (const auto& one : all)
        smallest = std::min(smallest, crossing(of, one.stress, one.rate, strength, limit));
      EXPECT_EQ(reference.value(), smallest) << number;
      n_searched += std::isfinite(smallest) ? 1 : 0;
      auto stream = RandomStream(6, 0, "order").substream(number);
      for (int trial = 0; trial < 8; ++trial) {
        for (std::size_t i = order.size(); i > 1; --i)
          std::swap(order[i - 1], order[static_cast<std::size_t>(stream.uniform(0, static_cast<double>(i)))]);
        const auto cut = order.begin() + static_cast<std::ptrdiff_t>(stream.uniform(0, 200));
        const FirstCrossing one = look(all, {order.begin(), cut}, limit);
        const FirstCrossing other = look(all, {cut, order.end()}, limit);
        const auto [value, tetrahedron] =
            std::min(std::pair(one.value(), one.number()), std::pair(other.value(), other.number()));
        EXPECT_EQ(value, reference.value()) << number << " in trial " << trial;
        EXPECT_EQ(std::isfinite(value) ? tetrahedron : -1, reference.number());
      }
    }
  }
  EXPECT_GT(n_searched, 30);
}

TEST(FirstCrossing, MeetsTheStrength) {
  for (std::uint64_t number = 0; number < 5; ++number) {
    const auto all = loaded(number, 1);
    for (const auto& one : all) {
      const double s = crossing(of, one.stress, one.rate, strength, infinity);
      if (std::isinf(s)) continue;
      mechanics::Symmetric sum = one.stress;
      for (std::size_t i = 0; i < 6; ++i) sum[i] += s * one.rate[i];
      EXPECT_NEAR(largest_principal(sum) / strength, 1, 1e-12);
      EXPECT_EQ(crossing(of, one.stress, one.rate, strength, 0.5 * s), infinity);
    }
  }
}

/// Among tetrahedra that cross at exactly the same time the smallest number wins.
TEST(FirstCrossing, TakesTheSmallestNumberOfEqualOnes) {
  const Loaded one{{1e6, 0, 0, 0, 0, 0}, {1e5, 0, 0, 0, 0, 0}};
  FirstCrossing first(of, infinity);
  for (const std::int64_t number : {7, 3, 9}) first.see(one.stress, one.rate, strength, number);
  EXPECT_EQ(first.number(), 3);
  EXPECT_NEAR(first.value(), 340, 1e-9);
}

}  // namespace CRACKLE_TEST_FILE
}  // namespace crackle::fracture
