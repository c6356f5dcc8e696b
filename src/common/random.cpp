// SPDX-License-Identifier: GPL-3.0-or-later
#include "common/random.h"

#include "common/checksum.h"

#include <cmath>
#include <numbers>

namespace crackle {

namespace {

/// The finalizer of SplitMix64: a bijection that mixes every bit into all others.
std::uint64_t mix(std::uint64_t value) {
  value += 0x9E3779B97F4A7C15u;
  value = (value ^ (value >> 30)) * 0xBF58476D1CE4E5B9u;
  value = (value ^ (value >> 27)) * 0x94D049BB133111EBu;
  return value ^ (value >> 31);
}

std::uint32_t low(std::uint64_t value) {
  return static_cast<std::uint32_t>(value);
}
std::uint32_t high(std::uint64_t value) {
  return static_cast<std::uint32_t>(value >> 32);
}

}  // namespace

std::array<std::uint32_t, 4> philox_4x32_10(std::array<std::uint32_t, 4> counter,
                                            std::array<std::uint32_t, 2> key) {
  for (int round = 0; round < 10; ++round) {
    const std::uint64_t product0 = std::uint64_t{0xD2511F53u} * counter[0];
    const std::uint64_t product1 = std::uint64_t{0xCD9E8D57u} * counter[2];
    counter = {high(product1) ^ counter[1] ^ key[0], low(product1), high(product0) ^ counter[3] ^ key[1],
               low(product0)};
    key[0] += 0x9E3779B9u;
    key[1] += 0xBB67AE85u;
  }
  return counter;
}

RandomStream::RandomStream(std::uint64_t seed, std::uint64_t sample, std::string_view purpose) {
  const std::uint64_t key = mix(mix(mix(seed) ^ sample) ^ checksum(purpose));
  key_ = {low(key), high(key)};
}

RandomStream RandomStream::substream(std::uint64_t index) const {
  RandomStream stream = *this;
  const std::uint64_t path = (std::uint64_t{counter_[3]} << 32) | counter_[2];
  const std::uint64_t nested = mix(mix(path) ^ index);
  stream.counter_ = {0, 0, low(nested), high(nested)};
  stream.used_ = 4;
  return stream;
}

std::uint64_t RandomStream::bits() {
  if (used_ == 4) {
    block_ = philox_4x32_10(counter_, key_);
    if (++counter_[0] == 0) ++counter_[1];
    used_ = 0;
  }
  const auto word = static_cast<std::size_t>(used_);
  used_ += 2;
  return (std::uint64_t{block_[word + 1]} << 32) | block_[word];
}

double RandomStream::uniform() {
  return static_cast<double>(bits() >> 11) * 0x1.0p-53;
}

double RandomStream::normal() {
  const double radius = std::sqrt(-2 * std::log(1 - uniform()));
  return radius * std::cos(2 * std::numbers::pi * uniform());
}

}  // namespace crackle
