// SPDX-License-Identifier: GPL-3.0-or-later
#include "crackle/common/quantity_text.h"
#include "crackle/common/text_table.h"
#include "crackle/experiment/calibration.h"
#include "text_parts.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <cmath>
#include <optional>

namespace crackle::experiment {

namespace {

using crackle::aligned;

std::string number_text(double value, const std::string& unit, double largest) {
  if (std::isnan(value)) return "-";
  return unit.empty() ? fmt::format("{:.4g}", value) : quantity_text(value, unit, 4, largest);
}

double scale_of(const Spread& spread) {
  return largest_magnitude({spread.mean, spread.lower, spread.upper});
}

std::string mean_text(const Spread& spread, const std::string& unit) {
  return number_text(spread.mean, unit, scale_of(spread));
}

std::string range_text(const Spread& spread, const std::string& unit) {
  const double largest = scale_of(spread);
  return fmt::format("{} to {}", number_text(spread.lower, unit, largest),
                     number_text(spread.upper, unit, largest));
}

std::string used_text(const Calibration& found) {
  std::vector<std::string> parts;
  if (!found.failed.empty()) parts.push_back(named(found.failed, "failed"));
  if (!found.undecided.empty()) parts.push_back(named(found.undecided, "undecided"));
  if (!found.missing.empty()) parts.push_back(named(found.missing, "missing"));
  if (!found.left_out.empty()) parts.push_back(named(found.left_out, "without all that is compared"));
  return fmt::format("{} of {} samples, {} draws; {}{}{}\n", found.n_used, found.n_planned, found.n_draws,
                     count_text(found.experiments.size(), "experiment"),
                     parts.empty() ? "" : "; left out: ", fmt::join(parts, ", "));
}

/// The head of a column of intervals.
std::string level_text() {
  return fmt::format("{:.4g} %", 100 * calibration_level);
}

std::string inputs_text(const Calibration& found) {
  TextTable rows{{"input", "prior", level_text(), "posterior", level_text(), "deviation, of the prior's"}};
  for (const CalibratedInput& each : found.inputs) {
    const std::string& unit = each.random.unit;
    rows.push_back({each.random.key, mean_text(each.prior, unit), range_text(each.prior, unit),
                    mean_text(each.posterior, unit), range_text(each.posterior, unit),
                    fmt::format("{:.2f}", each.ratio())});
  }
  return aligned(rows, 2, true);
}

std::string scales_text(const Calibration& found) {
  std::string text;
  for (const CalibratedScale& each : found.scales)
    text += fmt::format(
        "{} of {}: {} ({})\n", each.is_discrepancy ? "Discrepancy" : "Scatter between specimens",
        readable(each.quantity), mean_text(each.posterior, each.unit), range_text(each.posterior, each.unit));
  return text;
}

std::string ratios_text(const Information& information, const Calibration& found) {
  std::vector<std::string> ratios;
  for (std::size_t k = 0; k < found.inputs.size(); ++k)
    ratios.push_back(fmt::format(
        "{:.2f}", information.inputs[k].standard_deviation / found.inputs[k].prior.standard_deviation));
  return fmt::format("{}", fmt::join(ratios, ", "));
}

std::string contributions_text(const Calibration& found) {
  TextTable rows{{"from", "bits", "deviations", "without: bits", "deviations"}};
  for (const Contribution& each : found.contributions)
    rows.push_back({readable(each.quantity), fmt::format("{:.2f}", each.alone.bits),
                    ratios_text(each.alone, found),
                    each.without ? fmt::format("{:.2f}", each.without->bits) : "-",
                    each.without ? ratios_text(*each.without, found) : "-"});
  return aligned(rows, 2, true) +
         fmt::format("All together {:.2f} bits. Deviations of the inputs, of the prior's, in their order.\n",
                     found.bits);
}

std::string predictions_text(const Calibration& found) {
  TextTable rows{{"prediction", "observed", "mean", level_text(), "below the observed"}};
  for (const Prediction& each : found.predictions)
    rows.push_back({readable(each.name), number_text(each.observed, each.unit, scale_of(each.predicted)),
                    mean_text(each.predicted, each.unit), range_text(each.predicted, each.unit),
                    shown_percent(each.place)});
  return aligned(rows, 2, true);
}

std::string coverage_text(const CalibrationChecks& checks) {
  TextTable rows{{"coverage of", "interval", "covered", "95 % interval"}};
  for (const Coverage& each : checks.coverage)
    rows.push_back({each.key, shown_percent(each.level),
                    fmt::format("{} of {}", each.n_covered, each.n_draws),
                    fmt::format("{} to {}", shown_percent(each.lower), shown_percent(each.upper))});
  return aligned(rows, 2, true) +
         "Each draw's results as one experiment, by an emulator without it and the plain model.\n";
}

std::string emulator_text(const CalibrationChecks& checks) {
  TextTable rows{{"emulated", "degree", "predicted", "meshes", "lack of fit, p"}};
  for (const EmulatedComponent& each : checks.components)
    rows.push_back({readable(each.quantity), fmt::format("{}", each.degree), shown_percent(each.predicted),
                    shown_percent(each.mesh), shown_probability(each.lack_of_fit_p_value)});
  return aligned(rows, 2, true) +
         "Shares of the variance; that of the meshes is known with replicates only.\n";
}

std::string distance_text(const CalibrationChecks& checks) {
  std::string text = fmt::format(
      "Observations and model: {:.2f} standard deviations apart at least, in {}; p: {} ({:.2g} at "
      "least), ranked among left-out draws.\n",
      checks.distance, count_text(checks.n_components, "number"), shown_probability(checks.distance_p_value),
      checks.least_p_value);
  if (!std::isnan(checks.shape_p_value))
    text += fmt::format("Shape of the paths beyond their components, p: {}.\n",
                        shown_probability(checks.shape_p_value));
  return text;
}

}  // namespace

std::string to_text(const Calibration& found) {
  std::string text = used_text(found);
  for (const std::string& warning : found.warnings) text += fmt::format("warning: {}\n", warning);
  for (const std::string& note : found.notes) text += fmt::format("note: {}\n", note);
  text += "\n" + inputs_text(found) + scales_text(found);
  text += "\n" + contributions_text(found);
  text += "\n" + predictions_text(found);
  text += "\nChecks\n" + coverage_text(found.checks) + emulator_text(found.checks);
  text += distance_text(found.checks);
  return text + fmt::format("Effective size of the posterior: {:.0f} points.\n", found.checks.effective_size);
}

}  // namespace crackle::experiment
