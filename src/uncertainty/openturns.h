// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "crackle/input/parameters.h"

#include <cstdint>
#include <span>
#include <vector>

namespace crackle::uncertainty {

/// What random inputs take from OpenTURNS. Every function throws std::runtime_error where OpenTURNS fails.
class OpenTurns {
public:
  /// The value below which a share of a distribution lies [SI].
  virtual double quantile(const input::RandomInput& random, double probability) const = 0;
  /// Point `number` of the sequence in the unit cube.
  virtual std::vector<double> sobol_point(std::size_t n_dimensions, std::uint64_t number) const = 0;
  /// As uncertainty::orthonormal_polynomials.
  virtual std::vector<std::vector<double>> orthonormal_polynomials(const input::RandomInput& random,
                                                                   std::span<const double> values,
                                                                   int highest_degree) const = 0;

protected:
  ~OpenTurns() = default;
};

/// OpenTURNS, loaded when it is first needed: it comes with a hundred libraries, which would take each rank
/// 65 MB and a fifth of a second when the program starts.
/// @throws std::runtime_error when it cannot be loaded
const OpenTurns& openturns();

/// Name of the function of the module that gives it, and of the module's file.
inline constexpr const char* openturns_entry = "crackle_openturns";
inline constexpr const char* openturns_file = "crackle_openturns.so";

}  // namespace crackle::uncertainty
