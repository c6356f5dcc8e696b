// SPDX-License-Identifier: GPL-3.0-or-later
#include "analysis/sensitivity.h"
#include "common/index.h"
#include "input/reader.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <iterator>

namespace crackle::analysis {

namespace {

std::string name_of(const Sensitivity& result, const input::Sections& sections) {
  if (result.start >= 0)
    return fmt::format("start {}, {}", result.start, input::name_of(sections.all()[index(result.section)]));
  if (!result.share_of.empty()) return fmt::format("{}: {}", result.info.label, result.share_of);
  const std::string units = result.info.shown_units;  // distinguishes results with the same label
  return units.empty() ? result.info.label : fmt::format("{} [{}]", result.info.label, units);
}

std::string percent(double share) {
  return std::isnan(share) ? "-" : fmt::format("{:.0f}", 100 * share);
}

/// "62 (51-70)"
std::string percent(const Estimate& share) {
  if (std::isnan(share.lower)) return percent(share.value);
  return fmt::format("{} ({}-{})", percent(share.value), percent(share.lower), percent(share.upper));
}

}  // namespace

std::string note_on_plan(const input::Study& study) {
  const input::Ensemble& ensemble = study.ensemble;
  if (study.random.empty() || ensemble.plan == input::SamplingPlan::independent) return {};
  return fmt::format(
      "the draws of plan {} lie more evenly than independent ones: intervals of means and shares are wider "
      "than need be, some 2 times where the inputs rule a result, and p is too large",
      input::plan_names[static_cast<std::size_t>(ensemble.plan)]);
}

std::string to_text(const Sensitivities& sensitivities, const input::Study& study) {
  const auto& random = study.random;
  if (random.empty()) return {};
  std::string text = "\nrandom inputs\n";
  auto out = std::back_inserter(text);
  for (std::size_t k = 0; k < random.size(); ++k)
    fmt::format_to(out, "{}  {:<28} {}\n", k, random[k].key, input::describe(random[k]));
  fmt::format_to(out, "{} draws ({}), {} samples\n", sensitivities.n_draws,
                 input::plan_names[static_cast<std::size_t>(study.ensemble.plan)], sensitivities.n_samples);
  if (!sensitivities.failures.empty()) text += sensitivities.failures + "\n";
  if (const std::string note = note_on_plan(study); !note.empty()) text += note + "\n";
  if (sensitivities.results.empty()) {
    text += "too few draws for sensitivity indices\n";
    return text;
  }
  fmt::format_to(
      out,
      "\nshares of the variance [%] ({:g} % intervals) due to the mesh, and to each random input with its "
      "interactions (total Sobol' index); in brackets Spearman's rank correlation\n{:<30} {:>13}",
      100 * sensitivities.confidence, "", "mesh");
  for (std::size_t k = 0; k < random.size(); ++k) fmt::format_to(out, " {:>20}", fmt::format("input {}", k));
  fmt::format_to(out, " {:>10} {:>11} {:>6}\n", "predicted", "lack of fit", "draws");
  bool any_is_large = false, any_is_partial = false, any_is_bound = false;
  for (const Sensitivity& result : sensitivities.results) {
    fmt::format_to(out, "{:<30.30} {:>13}", name_of(result, study.sections), percent(result.mesh));
    for (const InputEffect& input : result.inputs)
      fmt::format_to(out, " {:>20}",
                     fmt::format("{} [{:+.2f}]", percent(input.total), input.rank_correlation.value));
    const bool is_large = result.lack_of_fit > large_lack_of_fit;
    any_is_large = any_is_large || is_large;
    any_is_bound = any_is_bound || result.n_bounds > 0;
    any_is_partial = any_is_partial || result.n_draws < sensitivities.n_draws;
    fmt::format_to(out, " {:>10} {:>11} {:>6}\n", percent(std::max(0.0, result.predicted)),
                   percent(result.lack_of_fit) + (is_large ? "!" : ""), result.n_draws);
  }
  if (any_is_partial)
    text +=
        "some results are of fewer draws, such as those that broke: the variance is that among these, and "
        "inputs "
        "share what is explained of it as they would among all draws\n";
  if (any_is_bound)
    text +=
        "loads of samples that did not break count as drawn above the largest applied, by a censored "
        "regression\n";
  if (!study.correlations.empty())
    text +=
        "the inputs are correlated: the variance cannot be shared among them by Sobol' indices, which "
        "suppose "
        "independent ones\n";
  if (any_is_large)
    fmt::format_to(out,
                   "!: the expansion does not follow the result, which may jump: its indices may be far off, "
                   "and their intervals too narrow\n");
  if (study.ensemble.replicates == 1)
    text += "without replicates, what is not predicted may be due to the mesh or to a lack of fit\n";
  return text;
}

}  // namespace crackle::analysis
