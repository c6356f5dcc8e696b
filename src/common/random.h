// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <array>
#include <cstdint>
#include <string_view>

namespace crackle {

/// The Philox 4x32-10 bijection of Salmon et al. (2011): 128 random bits for each counter under a key.
std::array<std::uint32_t, 4> philox_4x32_10(std::array<std::uint32_t, 4> counter,
                                            std::array<std::uint32_t, 2> key);

/// A random stream that depends on (seed, sample, purpose) only and gives the same numbers on every platform.
///
/// Counter-based (Philox 4x32-10): the k-th number of a stream is a function of the key, the stream's path of
/// substreams and k. The substreams of one stream never overlap; streams for different seeds, samples or
/// purposes, and deeper substreams, differ by 64-bit hashes. Copies continue independently from their current
/// state.
class RandomStream {
public:
  /// @param purpose label that makes different uses in one sample independent
  RandomStream(std::uint64_t seed, std::uint64_t sample, std::string_view purpose);

  /// The independent stream of item `index` (a mother point, a draw), always from its first number,
  /// regardless of the state of this stream. May be nested.
  RandomStream substream(std::uint64_t index) const;

  std::uint64_t bits();  ///< 64 uniform random bits
  double uniform();      ///< in [0, 1), 53 bits
  /// In [lower, upper), or `upper` itself due to rounding.
  double uniform(double lower, double upper) { return lower + (upper - lower) * uniform(); }
  double normal();  ///< standard normal, from two uniform numbers (Box and Muller)

private:
  std::array<std::uint32_t, 2> key_{};
  std::array<std::uint32_t, 4>
      counter_{};  ///< words 0, 1: number of the block; words 2, 3: path of substreams
  std::array<std::uint32_t, 4> block_{};
  int used_ = 4;  ///< words of the block already used
};

}  // namespace crackle
