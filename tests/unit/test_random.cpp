// SPDX-License-Identifier: GPL-3.0-or-later
#include "common/random.h"

#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <cstdint>
#include <set>
#include <vector>

namespace crackle::parallel {
namespace CRACKLE_TEST_FILE {

using Counter = std::array<std::uint32_t, 4>;

// The known answers distributed with Random123 (kat_vectors, philox4x32 with 10 rounds).
TEST(Philox, KnownAnswers) {
  EXPECT_EQ(philox_4x32_10({0, 0, 0, 0}, {0, 0}), (Counter{0x6627e8d5, 0xe169c58d, 0xbc57ac4c, 0x9b00dbd8}));
  EXPECT_EQ(philox_4x32_10({0xffffffff, 0xffffffff, 0xffffffff, 0xffffffff}, {0xffffffff, 0xffffffff}),
            (Counter{0x408f276d, 0x41c83b0e, 0xa20bc7c6, 0x6d5451fd}));
  EXPECT_EQ(philox_4x32_10({0x243f6a88, 0x85a308d3, 0x13198a2e, 0x03707344}, {0xa4093822, 0x299f31d0}),
            (Counter{0xd16cfe09, 0x94fdcceb, 0x5001e420, 0x24126ea1}));
}

// Fixes the numbers of a stream, so that old ensembles stay reproducible.
TEST(RandomStream, NumbersStayTheSame) {
  RandomStream stream(2012, 3, "disturbance");
  RandomStream again(2012, 3, "disturbance");
  std::vector<std::uint64_t> bits;
  for (int i = 0; i < 4; ++i) bits.push_back(stream.bits());
  for (const std::uint64_t value : bits) EXPECT_EQ(again.bits(), value);
  EXPECT_EQ(bits[0], 498492255016274752u);
  EXPECT_EQ(stream.substream(7).bits(), 14726387619724123172u);
}

TEST(RandomStream, DependsOnEachPartOfItsName) {
  std::set<std::uint64_t> first;
  for (std::uint64_t seed = 0; seed < 10; ++seed)
    for (std::uint64_t sample = 0; sample < 10; ++sample)
      for (const char* purpose : {"disturbance", "mother points", ""})
        first.insert(RandomStream(seed, sample, purpose).bits());
  EXPECT_EQ(first.size(), 300u);
}

TEST(RandomStream, SubstreamsAreIndependentOfThePosition) {
  RandomStream stream(1, 2, "test");
  RandomStream before = stream.substream(5);
  for (int i = 0; i < 7; ++i) stream.bits();
  RandomStream after = stream.substream(5);
  for (int i = 0; i < 10; ++i) EXPECT_EQ(before.bits(), after.bits());
}

TEST(RandomStream, SubstreamsDiffer) {
  const RandomStream stream(1, 2, "test");
  std::set<std::uint64_t> first{RandomStream(stream).bits()};
  for (std::uint64_t i = 0; i < 200; ++i) {
    first.insert(stream.substream(i).bits());
    for (std::uint64_t j = 0; j < 20; ++j) first.insert(stream.substream(i).substream(j).bits());
  }
  EXPECT_EQ(first.size(), 1u + 200 + 200 * 20);
}

TEST(RandomStream, UniformInTheUnitInterval) {
  RandomStream stream(2012, 0, "uniformity");
  constexpr int n = 400000;
  double sum = 0;
  double square = 0;
  double product = 0;
  double last = 0.5;
  std::array<int, 64> bins{};
  for (int i = 0; i < n; ++i) {
    const double u = stream.uniform();
    ASSERT_GE(u, 0.0);
    ASSERT_LT(u, 1.0);
    sum += u;
    square += u * u;
    product += (u - 0.5) * (last - 0.5);
    last = u;
    ++bins[static_cast<std::size_t>(64 * u)];
  }
  double chi = 0;
  for (const int count : bins) chi += std::pow(count - n / 64.0, 2) / (n / 64.0);
  std::printf("mean %.6f, mean square %.6f, lag-1 covariance %.2e, chi2 of 64 bins %.1f\n", sum / n,
              square / n, product / n, chi);
  EXPECT_NEAR(sum / n, 0.5, 5 * std::sqrt(1.0 / 12 / n));
  EXPECT_NEAR(square / n, 1.0 / 3, 5 * std::sqrt(4.0 / 45 / n));
  EXPECT_NEAR(product / n, 0, 5.0 / 12 / std::sqrt(n));
  EXPECT_GT(chi, 25);  // both tails beyond 5 sigma of chi-squared with 63 degrees of freedom
  EXPECT_LT(chi, 130);
}

TEST(RandomStream, UniformInAnInterval) {
  RandomStream stream(1, 1, "interval");
  RandomStream same(1, 1, "interval");
  for (int i = 0; i < 100; ++i) EXPECT_DOUBLE_EQ(stream.uniform(-3, 5), -3 + 8 * same.uniform());
}

}  // namespace CRACKLE_TEST_FILE
}  // namespace crackle::parallel
