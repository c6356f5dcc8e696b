// SPDX-License-Identifier: GPL-3.0-or-later
#include "crackle/parallel/reproducible.h"

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <cstddef>

namespace crackle::parallel {

namespace {

constexpr int bits_per_part = 36;
/// The last bits of a double near this are an integer below 2^51 in magnitude.
constexpr double shift = 6755399441055744.0;
constexpr std::int64_t shift_bits = 0x4338000000000000;

/// The bits of the largest magnitude among the products. Bits of magnitudes are ordered as the magnitudes
/// are, with those of NaN above infinity: unlike a comparison of doubles, this loses no NaN, here or between
/// ranks.
std::int64_t largest_product(std::span<const double> a, std::span<const double> b) {
  std::int64_t largest = 0;
  for (std::size_t i = 0; i < a.size(); ++i)
    largest = std::max(largest, std::bit_cast<std::int64_t>(std::abs(a[i] * b[i])));
  return largest;
}

std::array<std::int64_t, 2> sum_parts(std::span<const double> a, std::span<const double> b, double to_high) {
  const double from_high = 1 / to_high;
  const double to_low = to_high * std::ldexp(1.0, bits_per_part);
  std::int64_t high = 0, low = 0;
  for (std::size_t i = 0; i < a.size(); ++i) {
    const double product = a[i] * b[i];
    const double shifted = product * to_high + shift;
    high += std::bit_cast<std::int64_t>(shifted) - shift_bits;
    const double rest = product - (shifted - shift) * from_high;
    low += std::bit_cast<std::int64_t>(rest * to_low + shift) - shift_bits;
  }
  return {high, low};
}

/// Calls work(value of x, value of y to change) for every place. Plain loops: BLAS may fuse operations
/// differently at the ends of an array.
template <class Work>
void update(Vec x, Vec y, const Work& work) {
  const ReadValues x_values(x);
  const WrittenValues y_values(y);
  const std::span from = *x_values;
  const std::span to = *y_values;
  for (std::size_t i = 0; i < from.size(); ++i) work(from[i], to[i]);
}

void add(double factor, Vec x, Vec y) {
  update(x, y, [factor](double from, double& to) { to += factor * from; });
}

double dot(Vec x, Vec y) {
  const ReadValues a(x), b(y);
  return reproducible_dot(PetscObjectComm(reinterpret_cast<PetscObject>(x)), *a, *b);
}

VecOwner duplicate(Vec like) {
  VecOwner vector;
  check_petsc(VecDuplicate(like, vector.put()), "VecDuplicate");
  return vector;
}

}  // namespace

double reproducible_dot(MPI_Comm communicator, std::span<const double> a, std::span<const double> b) {
  std::int64_t largest_bits = largest_product(a, b);
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

ConjugateGradients::ConjugateGradients(Vec like)
    : preconditioned_(duplicate(like)), direction_(duplicate(like)), image_(duplicate(like)) {}

ConjugateGradients::Outcome ConjugateGradients::solve(Mat matrix, PC preconditioner, Vec residual,
                                                      Vec solution, double tolerance, int max_iterations) {
  const Vec z = preconditioned_.get(), p = direction_.get(), w = image_.get();
  check_petsc(VecSet(solution, 0), "VecSet");
  double beta_before = 0;
  for (int n = 0;; ++n) {
    check_petsc(PCApply(preconditioner, residual, z), "PCApply");
    const double beta = dot(z, residual);
    const double norm = std::sqrt(std::abs(beta));
    if (norm <= tolerance) return {true, n};
    if (n == max_iterations || !std::isfinite(norm)) return {false, n};
    const double ratio = n == 0 ? 0 : beta / beta_before;
    update(z, p, [n, ratio](double from, double& to) { to = n == 0 ? from : from + ratio * to; });
    check_petsc(MatMult(matrix, p, w), "MatMult");
    const double curvature = dot(p, w);
    if (!(curvature > 0)) return {false, n + 1};
    const double step = beta / curvature;
    add(step, p, solution);
    add(-step, w, residual);
    beta_before = beta;
  }
}

}  // namespace crackle::parallel
