// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "crackle/input/parameters.h"

#include <cstdint>
#include <span>
#include <vector>

namespace crackle::uncertainty {

/// Functions provided by OpenTURNS. Each throws std::runtime_error if OpenTURNS fails.
class OpenTurns {
public:
  /// The quantile of a distribution [SI].
  virtual double quantile(const input::RandomInput& random, double probability) const = 0;
  /// Point `number` of the sequence in the unit cube; the first one is the origin.
  virtual std::vector<double> sobol_point(std::size_t n_dimensions, std::uint64_t number) const = 0;
  /// As uncertainty::orthonormal_polynomials.
  virtual std::vector<std::vector<double>> orthonormal_polynomials(const input::RandomInput& random,
                                                                   std::span<const double> values,
                                                                   int highest_degree) const = 0;

protected:
  ~OpenTurns() = default;
};

/// OpenTURNS, loaded on first use: its hundred libraries would cost each rank 65 MB and a fifth of a second
/// at startup.
/// @throws std::runtime_error when it cannot be loaded
const OpenTurns& openturns();

/// Name of the module's entry function, and of its file.
inline constexpr const char* openturns_entry = "crackle_openturns";
inline constexpr const char* openturns_file = "crackle_openturns.so";

}  // namespace crackle::uncertainty
