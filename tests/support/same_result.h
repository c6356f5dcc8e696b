// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "dynamics/sample_result.h"

#include <gtest/gtest.h>

#include <array>
#include <bit>
#include <cstddef>
#include <cstdint>
#include <tuple>
#include <utility>
#include <vector>

namespace crackle::test {

/// Expects bitwise equality of the numbers that describe how a sample broke and ended, including NaN, and of
/// the history.
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
                                     {"separated_at", &Result::separated_at},
                                     {"stable_step", &Result::stable_step},
                                     {"energy_error", &Result::energy_error},
                                     {"equilibrium_residual", &Result::equilibrium_residual}})
    EXPECT_EQ(std::bit_cast<std::uint64_t>(a.*number), std::bit_cast<std::uint64_t>(b.*number))
        << name << ": " << a.*number << " and " << b.*number;
  EXPECT_TRUE(a.mass_scaling == b.mass_scaling);
}

template <typename Row, typename Fields>
void expect_same_rows(const char* name, const std::vector<Row>& a, const std::vector<Row>& b, Fields fields) {
  ASSERT_EQ(a.size(), b.size()) << name;
  for (std::size_t i = 0; i < a.size(); ++i) ASSERT_EQ(fields(a[i]), fields(b[i])) << name << ' ' << i;
}

/// Expects bitwise equality of the samples' course, from the first break to the last frame.
inline void expect_same_course(const dynamics::SampleResult& a, const dynamics::SampleResult& b) {
  expect_same_end(a, b);
  expect_same_rows("break", a.breaks, b.breaks, [](const fracture::Break& r) {
    return std::tuple(r.tetrahedron, r.load_time, r.phase_time, r.principal_stress, r.released_energy, r.cut);
  });
  expect_same_rows("bridge", a.bridge_releases, b.bridge_releases, [](const fracture::BridgeRelease& r) {
    return std::tuple(r.tetrahedron, r.load_time, r.phase_time, r.released_energy, r.edges);
  });
  expect_same_rows(
      "tooth", a.stiffness_reductions, b.stiffness_reductions, [](const fracture::StiffnessReduction& r) {
        return std::tuple(r.tetrahedron, r.load_time, r.phase_time, r.released_energy, r.share, r.ductility);
      });
  expect_same_rows("energy", a.energy, b.energy, [](const dynamics::EnergyRow& r) {
    return std::bit_cast<std::array<std::uint64_t, sizeof(r) / sizeof(std::uint64_t)>>(r);
  });
  expect_same_rows("frame", a.frames, b.frames,
                   [](const auto& r) { return std::tie(r.time, r.displacement, r.velocity, r.broken); });
  const auto fields_of = [](const dynamics::Fragment& r) {
    return std::tuple(r.first_node, r.n_nodes, r.mass, r.volume, r.center, r.velocity, r.kinetic, r.extent,
                      r.is_frozen);
  };
  expect_same_rows("fragment", a.fragments.pieces, b.fragments.pieces, fields_of);
  EXPECT_EQ(fields_of(a.fragments.dust), fields_of(b.fragments.dust));
  EXPECT_EQ(a.fragments.of_node, b.fragments.of_node);
  expect_same_rows("number of fragments", a.fragment_history, b.fragment_history,
                   [](const dynamics::FragmentCount& r) {
                     return std::tuple(r.time, r.number, r.largest_mass, r.second_mass, r.dust, r.dust_mass,
                                       r.frozen, r.frozen_mass, r.frozen_energy);
                   });
  EXPECT_EQ(a.counts.steps, b.counts.steps);
  EXPECT_EQ(a.counts.force_evaluations, b.counts.force_evaluations);
  EXPECT_EQ(a.counts.dynamic_phases, b.counts.dynamic_phases);
  EXPECT_EQ(a.counts.quasi_static_breaks, b.counts.quasi_static_breaks);
  EXPECT_EQ(a.counts.range_restarts, b.counts.range_restarts);
}

}  // namespace crackle::test
