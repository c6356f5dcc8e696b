// SPDX-License-Identifier: GPL-3.0-or-later
#include "parallel/exact_sum.h"

#include "common/index.h"
#include "parallel/agreement.h"
#include "parallel/collectives.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <stdexcept>

namespace crackle::parallel {

namespace {

constexpr int bits_per_digit = 32;
constexpr std::int64_t digit_mask = (std::int64_t{1} << bits_per_digit) - 1;
constexpr int lowest_exponent = -1074;  // of the smallest subnormal double
// A term adds less than 2^32 to a digit, so an int64 digit stays far from its limits for this many terms.
constexpr std::int64_t max_terms_before_carry = std::int64_t{1} << 30;

/// The sum of the terms added by add_terms(sum) on each rank. If a term is invalid on one rank, no rank
/// enters the reduction. Collective.
template <class AddTerms>
double agreed_sum(const Communicator& group, const AddTerms& add_terms) {
  ExactSum sum = agree(group, [&] {
    ExactSum local;
    add_terms(local);
    return local;
  });
  sum.all_reduce(group);
  return sum.value();
}

}  // namespace

void ExactSum::add(double term) {
  if (!std::isfinite(term)) throw std::domain_error("exact sum: a term is not finite");
  if (term == 0) return;
  const auto bits = std::bit_cast<std::uint64_t>(term);
  const auto biased = static_cast<int>((bits >> 52) & 0x7ff);
  std::uint64_t mantissa = bits & ((std::uint64_t{1} << 52) - 1);
  if (biased != 0) mantissa |= std::uint64_t{1} << 52;
  const int position = biased == 0 ? 0 : biased - 1;  // exponent of the mantissa's last bit above 2^-1074
  const int first = position / bits_per_digit;
  const int shift = position % bits_per_digit;
  const std::uint64_t low = (mantissa & 0xffffffffULL) << shift;
  const std::uint64_t high = (mantissa >> 32) << shift;
  const std::int64_t parts[3] = {static_cast<std::int64_t>(low & 0xffffffffULL),
                                 static_cast<std::int64_t>((low >> 32) + (high & 0xffffffffULL)),
                                 static_cast<std::int64_t>(high >> 32)};
  if (term > 0) {
    for (int i = 0; i < 3; ++i) digit_[index(first + i)] += parts[i];
  } else {
    for (int i = 0; i < 3; ++i) digit_[index(first + i)] -= parts[i];
  }
  if (++terms_since_carry_ == max_terms_before_carry) carry();
}

void ExactSum::carry() {
  // Arithmetic shift rounds down, so all digits but the last become non-negative, which makes the
  // representation unique.
  for (std::size_t d = 0; d + 1 < n_digits; ++d) {
    digit_[d + 1] += digit_[d] >> bits_per_digit;
    digit_[d] &= digit_mask;
  }
  terms_since_carry_ = 0;
}

double ExactSum::value() const {
  ExactSum normal = *this;
  normal.carry();
  const bool negative = normal.digit_[n_digits - 1] < 0;
  if (negative) {
    for (auto& digit : normal.digit_) digit = -digit;
    normal.carry();
  }
  // Three leading digits hold at least 65 significant bits; the rest cannot change the result by an ulp.
  int top = n_digits - 1;
  while (top > 0 && normal.digit_[index(top)] == 0) --top;
  double sum = 0;
  for (int d = std::max(0, top - 2); d <= top; ++d) {
    sum += std::ldexp(static_cast<double>(normal.digit_[index(d)]), bits_per_digit * d + lowest_exponent);
  }
  return negative ? -sum : sum;
}

void ExactSum::all_reduce(const Communicator& group) {
  carry();
  parallel::all_reduce(group, digit_, MPI_SUM);
  carry();
}

std::vector<double> ExactSum::of_each(const Communicator& group, std::span<const std::vector<double>> terms) {
  std::vector<ExactSum> sums;
  std::vector<std::int64_t> digits;
  std::vector<double> values;
  agree(group, [&] {
    sums.resize(terms.size());
    values.resize(terms.size());
    digits.reserve(terms.size() * n_digits);
    for (std::size_t i = 0; i < sums.size(); ++i) {
      for (const double term : terms[i]) sums[i].add(term);
      sums[i].carry();
      digits.insert(digits.end(), sums[i].digit_.begin(), sums[i].digit_.end());
    }
  });
  parallel::all_reduce(group, digits, MPI_SUM);
  for (std::size_t i = 0; i < sums.size(); ++i) {
    std::copy_n(digits.begin() + std::ssize(sums[i].digit_) * static_cast<std::ptrdiff_t>(i), n_digits,
                sums[i].digit_.begin());
    values[i] = sums[i].value();
  }
  return values;
}

double integer_sum(const Communicator& group, __int128 mine) {
  constexpr int bits = 48;
  constexpr __int128 mask = (__int128{1} << bits) - 1;
  std::array<std::int64_t, 3> parts{static_cast<std::int64_t>(mine & mask),
                                    static_cast<std::int64_t>((mine >> bits) & mask),
                                    static_cast<std::int64_t>(mine >> 2 * bits)};
  parallel::all_reduce(group, parts, MPI_SUM);
  return static_cast<double>(((static_cast<__int128>(parts[2]) << bits) + parts[1]) * (mask + 1) + parts[0]);
}

double exact_sum(const Communicator& group, std::span<const double> terms) {
  return agreed_sum(group, [&](ExactSum& sum) {
    for (const double term : terms) sum.add(term);
  });
}

std::vector<double> exact_sums(const Communicator& group, std::span<const std::vector<double>> terms) {
  return terms.empty() ? std::vector<double>() : ExactSum::of_each(group, terms);
}

double exact_dot(const Communicator& group, std::span<const double> a, std::span<const double> b) {
  return agreed_sum(group, [&](ExactSum& sum) {
    for (std::size_t i = 0; i < a.size(); ++i) sum.add(a[i] * b[i]);
  });
}

}  // namespace crackle::parallel
