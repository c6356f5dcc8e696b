// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "crackle/dynamics/sample_result.h"

#include <gtest/gtest.h>

#include <bit>
#include <cstddef>
#include <cstdint>
#include <utility>

namespace crackle::test {

/// The numbers that tell how a sample broke and ended have the same bits, NaN included, and its history the
/// same rows.
inline void expect_same_end(const dynamics::SampleResult& a, const dynamics::SampleResult& b) {
  using Result = dynamics::SampleResult;
  EXPECT_EQ(a.outcome, b.outcome);
  EXPECT_EQ(a.note, b.note);
  ASSERT_EQ(a.history.size(), b.history.size());
  EXPECT_GT(a.history.size(), 0U);
  for (std::size_t i = 0; i < a.history.size(); ++i) ASSERT_TRUE(a.history[i] == b.history[i]) << "row " << i;
  for (const auto& [name, number] : {std::pair{"first_break_time", &Result::first_break_time},
                                     {"first_break_load", &Result::first_break_load},
                                     {"onset_time", &Result::onset_time},
                                     {"onset_force", &Result::onset_force},
                                     {"phase_start", &Result::phase_start},
                                     {"stable_step", &Result::stable_step},
                                     {"energy_error", &Result::energy_error},
                                     {"equilibrium_residual", &Result::equilibrium_residual}})
    EXPECT_EQ(std::bit_cast<std::uint64_t>(a.*number), std::bit_cast<std::uint64_t>(b.*number))
        << name << ": " << a.*number << " and " << b.*number;
}

}  // namespace crackle::test
