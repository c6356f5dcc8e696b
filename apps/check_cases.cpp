// SPDX-License-Identifier: GPL-3.0-or-later
#include "check_cases.h"

#include "crackle/common/text_table.h"
#include "crackle/dynamics/model_limits.h"
#include "crackle/geometry/body.h"
#include "crackle/geometry/mother_points.h"

#include "check_subject.h"

#include <fmt/format.h>

#include <algorithm>
#include <stdexcept>

namespace crackle::apps {

namespace {

std::vector<std::string> warnings_of(const input::Case& one) {
  return dynamics::model_warnings(one.parameters, *geometry::make_body(one.parameters));
}

/// Core-hours of a case whose samples take so long [s].
double core_hours(const input::Case& one, double seconds) {
  return one.parameters.ensemble.samples * seconds / 3600;
}

NamedValue cost_line(std::size_t number, const FirstSample& subject, double seconds, double hours) {
  return {fmt::format("case {}", number),
          fmt::format("{} tetrahedra, {} steps, {:.0f} MB; sample {}, {:.3g} core-hours",
                      subject.realization.tetrahedra.size(), subject.phase.grid.n_steps,
                      subject.memory() / 1e6, duration_text(seconds), hours)};
}

}  // namespace

void print_cases(const std::vector<input::Case>& cases) {
  if (cases.empty()) return;
  fmt::print("{} cases:\n", cases.size());
  for (std::size_t i = 0; i < cases.size(); ++i) fmt::print("{:>4}  {}\n", i, to_string(cases[i].settings));
  for (const std::string& warning : input::sweep_warnings(cases)) fmt::print("\nWarning: {}\n", warning);
  fmt::print("\n");
}

std::vector<std::string> print_other_cases(const std::vector<input::Case>& cases,
                                           const std::optional<SampleTime>& first,
                                           const TrialExtent& extent) {
  std::vector<std::string> failures;
  std::vector<std::string> known = warnings_of(cases.front());
  std::vector<NamedValue> costs;
  double all_hours = first ? core_hours(cases.front(), first->cost.total()) : 0;
  for (std::size_t i = 1; i < cases.size(); ++i) {
    const input::Parameters& parameters = cases[i].parameters;
    for (const std::string& warning : warnings_of(cases[i])) {
      if (std::ranges::find(known, warning) != known.end()) continue;
      known.push_back(warning);
      fmt::print("\nWarning: case {}: {}\n", i, warning);
    }
    if (!first && extent.samples == 0) continue;
    try {
      const auto body = geometry::make_body(parameters);
      geometry::MotherPoints base;
      const FirstSample subject = make_subject(parameters, *body, base);
      if (extent.samples > 0) {
        fmt::print("\nCase {}: {}", i, to_string(cases[i].settings));
        for (const std::string& failure : try_samples(subject, base, extent))
          failures.push_back(fmt::format("case {}: {}", i, failure));
      }
      if (!first) continue;
      const double seconds = scaled_seconds(*first, subject);
      const double hours = core_hours(cases[i], seconds);
      costs.push_back(cost_line(i, subject, seconds, hours));
      all_hours += hours;
    } catch (const std::runtime_error& error) {
      failures.push_back(fmt::format("case {}: {}", i, error.what()));
    }
  }
  if (!costs.empty()) {
    costs.emplace_back("all cases", fmt::format("{:.3g} core-hours", all_hours));
    fmt::print("\nThe other cases, from their meshes and the time of the first:\n{}", aligned(costs));
  }
  return failures;
}

}  // namespace crackle::apps
