// SPDX-License-Identifier: GPL-3.0-or-later
#include "parallel/reproducible.h"

#include "common/real.h"
#include "parallel/collectives.h"

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <cstddef>
#include <type_traits>

namespace crackle::parallel {

namespace {

constexpr int bits_per_part = 36;
/// The low bits of a double near this value are an integer below 2^51 in magnitude.
constexpr double shift = 6755399441055744.0;
constexpr std::int64_t shift_bits = 0x4338000000000000;

template <class Real>
std::array<std::int64_t, 2> sum_parts(std::span<const Real> a, std::span<const Real> b, double to_high) {
  const double from_high = 1 / to_high;
  const double to_low = to_high * std::ldexp(1.0, bits_per_part);
  std::int64_t high = 0, low = 0;
  for (std::size_t i = 0; i < a.size(); ++i) {
    const double product = static_cast<double>(a[i]) * static_cast<double>(b[i]);
    const double shifted = product * to_high + shift;
    high += std::bit_cast<std::int64_t>(shifted) - shift_bits;
    const double rest = product - (shifted - shift) * from_high;
    low += std::bit_cast<std::int64_t>(rest * to_low + shift) - shift_bits;
  }
  return {high, low};
}

/// The largest magnitude passed to see() by each(see). The bits of magnitudes are ordered like the
/// magnitudes, with NaN above infinity: unlike a comparison of numbers, this never loses a NaN, here or
/// between ranks.
template <class Real, class Each>
Real largest_of(const Each& each) {
  using Bits = std::conditional_t<sizeof(Real) == 4, std::int32_t, std::int64_t>;
  Bits largest = 0;
  each([&](Real x) { largest = std::max(largest, std::bit_cast<Bits>(std::abs(x))); });
  return std::bit_cast<Real>(largest);
}

template <class Real>
double largest_product(std::span<const Real> a, std::span<const Real> b) {
  return largest_of<double>([&](const auto& see) {
    for (std::size_t i = 0; i < a.size(); ++i) see(static_cast<double>(a[i]) * static_cast<double>(b[i]));
  });
}

template <class Real>
double largest_number(const Communicator& group, std::span<const Real> numbers) {
  const Real largest = largest_of<Real>([&](const auto& see) {
    for (const Real x : numbers) see(x);
  });
  return largest_of_all(group, std::isnan(largest) ? infinity : static_cast<double>(largest));
}

template <class Real>
double dot(MPI_Comm communicator, std::span<const Real> a, std::span<const Real> b, double bound) {
  auto largest_bits = std::bit_cast<std::int64_t>(std::abs(bound));
  int n_ranks = 1;
  check_mpi(MPI_Comm_size(communicator, &n_ranks), "MPI_Comm_size");
  if (n_ranks > 1)
    check_mpi(MPI_Allreduce(MPI_IN_PLACE, &largest_bits, 1, MPI_INT64_T, MPI_MAX, communicator),
              "MPI_Allreduce");
  const auto largest = std::bit_cast<double>(largest_bits);
  if (largest == 0 || !std::isfinite(largest)) return largest;
  const int exponent = std::max(std::ilogb(largest), -900) + 1;
  const double to_high = std::ldexp(1.0, bits_per_part - exponent);
  auto parts = sum_parts(a, b, to_high);
  if (n_ranks > 1)
    check_mpi(MPI_Allreduce(MPI_IN_PLACE, parts.data(), 2, MPI_INT64_T, MPI_SUM, communicator),
              "MPI_Allreduce");
  return static_cast<double>(parts[0]) / to_high +
         std::ldexp(static_cast<double>(parts[1]) / to_high, -bits_per_part);
}

}  // namespace

double largest_magnitude(const Communicator& group, std::span<const double> numbers) {
  return largest_number(group, numbers);
}

double largest_magnitude(const Communicator& group, std::span<const float> numbers) {
  return largest_number(group, numbers);
}

double reproducible_dot(MPI_Comm communicator, std::span<const double> a, std::span<const double> b) {
  return dot(communicator, a, b, largest_product(a, b));
}

double reproducible_dot(MPI_Comm communicator, std::span<const float> a, std::span<const float> b) {
  return dot(communicator, a, b, largest_product(a, b));
}

double reproducible_dot(MPI_Comm communicator, std::span<const float> a, std::span<const float> b,
                        double bound) {
  return dot(communicator, a, b, bound);
}

}  // namespace crackle::parallel
