// SPDX-License-Identifier: GPL-3.0-or-later
#include "crackle/ensemble/sample_report.h"

#include "crackle/parallel/packing.h"

#include <fmt/format.h>

namespace crackle::ensemble {

std::vector<std::byte> to_bytes(const SampleReport& report) {
  parallel::Packer packer;
  packer.put(report.sample);
  packer.put(report.stored);
  packer.put(report.parked);
  packer.put(report.mesh_attempt);
  packer.put(report.n_tetrahedra);
  packer.put(report.seconds);
  packer.put(analysis::to_bytes(report.summary));
  return packer.bytes();
}

SampleReport report_from_bytes(std::span<const std::byte> bytes) {
  parallel::Unpacker unpacker(bytes);
  SampleReport report;
  report.sample = unpacker.get<std::uint64_t>();
  report.stored = unpacker.get<bool>();
  report.parked = unpacker.get<bool>();
  report.mesh_attempt = unpacker.get<int>();
  report.n_tetrahedra = unpacker.get<std::int64_t>();
  report.seconds = unpacker.get<double>();
  report.summary = analysis::summary_from_bytes(unpacker.get_vector<std::byte>());
  return report;
}

namespace {

const char* pattern_name(std::int32_t pattern) {
  switch (static_cast<analysis::Pattern>(pattern)) {
    case analysis::Pattern::none:
      return "no crack across";
    case analysis::Pattern::one_crack:
      return "one crack";
    case analysis::Pattern::two_cracks:
      return "two cracks";
    case analysis::Pattern::other:
      break;
  }
  return "other pattern";
}

}  // namespace

std::string describe(const SampleReport& report) {
  const auto& summary = report.summary;
  if (report.parked) return fmt::format("sample {} parked after {:.1f} s", report.sample, report.seconds);
  if (summary.status != analysis::SampleStatus::done) {
    return fmt::format("sample {} failed after {:.1f} s: {}", report.sample, report.seconds, summary.error);
  }
  return fmt::format(
      "sample {} done: onset {:.1f} N, {}, {:.1f} mm^2 of crack, {} breaks, energy error {:.1e}, {:.1f} s{}",
      report.sample, summary.onset_force, pattern_name(summary.pattern), summary.crack_area * 1e6,
      summary.breaks, summary.energy_error, report.seconds,
      report.mesh_attempt == 0 ? "" : fmt::format(", mesh made at attempt {}", report.mesh_attempt + 1));
}

std::vector<std::string> describe(const dynamics::SampleResult& result) {
  const auto& counts = result.counts;
  const auto& timings = result.timings;
  return {
      fmt::format("outcome: {}", dynamics::to_string(result.outcome)),
      fmt::format("t0 = {:.6f} s, load {:.2f} N", result.onset_time, result.onset_force),
      fmt::format(
          "{} breaks, {} of them quasi-static; {} dynamic phases; {} static solves with {} iterations",
          result.breaks.size(), counts.quasi_static_breaks, counts.dynamic_phases, counts.static_solves,
          counts.solver_iterations),
      fmt::format("{} steps of {:.3f} ns (stable up to {:.3f} ns), {} force evaluations", counts.steps,
                  result.time_step * 1e9, result.stable_step * 1e9, counts.force_evaluations),
      fmt::format("energy error {:.2e} of the work done", result.energy_error),
      fmt::format("mesh {:.1f} s, setup {:.1f} s, quasi-static {:.1f} s, dynamic {:.1f} s", timings.mesh,
                  timings.setup, timings.quasi_static, timings.dynamic),
      fmt::format("{:.3e} element updates per second", timings.element_updates_per_second),
  };
}

}  // namespace crackle::ensemble
