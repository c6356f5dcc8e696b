// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <array>
#include <cstdint>
#include <string_view>

namespace crackle::parallel {

/// A random stream that depends on (seed, sample, purpose) only and gives the same numbers on every platform.
///
/// Counter-based (Philox 4x32-10, Salmon et al. 2011): the k-th number of a stream is a function of the key
/// and k, so streams for different samples or purposes never overlap, and `substream` gives an independent
/// one per item.
class RandomStream {
public:
  RandomStream(std::uint64_t seed, std::uint64_t sample, std::string_view purpose);

  /// The independent stream of item `index` (a mother point, a redraw round).
  RandomStream substream(std::uint64_t index) const;

  std::uint64_t bits();  ///< 64 uniform random bits
  double uniform();      ///< in [0, 1), 53 bits
  double uniform(double lower, double upper) { return lower + (upper - lower) * uniform(); }

private:
  std::array<std::uint32_t, 2> key_{};
  std::array<std::uint32_t, 4> counter_{};
  std::array<std::uint32_t, 4> block_{};
  int used_ = 4;
};

}  // namespace crackle::parallel
