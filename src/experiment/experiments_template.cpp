// SPDX-License-Identifier: GPL-3.0-or-later
#include "crackle/analysis/statistics.h"
#include "crackle/experiment/matching.h"
#include "crackle/geometry/outline.h"
#include "crackle/input/reader.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <cmath>
#include <iterator>
#include <string_view>

namespace crackle::experiment {

namespace {

std::string in_millimetres(double y, double z) {
  return fmt::format("y = {:.4g} mm, z = {:.4g} mm", 1e3 * y, 1e3 * z);
}

/// The body's bounds and crack starts, by which an experiment is placed in it.
std::string body_text(const geometry::Body& body, const input::Parameters& parameters) {
  const auto& [lower, upper] = body.bounds();
  std::string text = fmt::format("# The body goes from {} to {}.\n", in_millimetres(lower[1], lower[2]),
                                 in_millimetres(upper[1], upper[2]));
  const geometry::Outline outline = geometry::outline_of(body);
  for (std::size_t i = 0; i < outline.names.size(); ++i) {
    const geometry::CrackStart& start = body.crack_starts()[i];
    if (start.is_free_surface) continue;
    const double* const slot = &outline.slots[4 * i];  // min and max y, min and max z
    text += start.is_straight
                ? fmt::format("# Cracks start from {} at {}.\n", outline.names[i],
                              in_millimetres(start.tip[1], start.tip[2]))
                : fmt::format("# Cracks start from the walls of {}, from {} to {}.\n", outline.names[i],
                              in_millimetres(slot[0], slot[2]), in_millimetres(slot[1], slot[3]));
  }
  std::vector<std::string> sections;
  for (const input::Section& section : parameters.sections.all()) sections.push_back(input::name_of(section));
  if (!sections.empty()) text += fmt::format("# Sections: {}.\n", fmt::join(sections, "; "));
  return text;
}

std::string load_line(const char* key, const std::vector<double>& loads) {
  const double median = analysis::quantile(loads, 0.5);
  if (std::isnan(median)) return {};
  return fmt::format("{} = \"{:.4g} N\"    # made up: the median of {} samples, {:.4g} to {:.4g} N\n", key,
                     median, loads.size(), analysis::quantile(loads, 0), analysis::quantile(loads, 1));
}

/// Loads that samples have, for the experiment to begin with.
std::string load_lines(const ObservedSamples& samples) {
  std::vector<double> onset, peak;
  bool is_peak = false;
  for (const ObservedSample& sample : samples.samples) {
    const auto& row = sample.summary;
    is_peak = is_peak || (!std::isnan(row.onset_force) &&
                          analysis::headline_load({&row, 1}) == std::string_view("peak_load"));
    if (const double load = load_of(row, Quantity::onset_load); !std::isnan(load)) onset.push_back(load);
    if (!std::isnan(row.peak_load)) peak.push_back(row.peak_load);
  }
  // The onset is not what a test would record where the load was higher before.
  if (is_peak) onset.clear();
  const std::string lines = load_line("onset_load", onset) + load_line("peak_load", peak);
  return lines.empty() ? "peak_load = \"100 N\"    # made up\n" : lines;
}

}  // namespace

std::string experiments_template(const ObservedSamples& samples, const geometry::Body& body,
                                 const input::Parameters& parameters, const std::string& folder) {
  return fmt::format(
      "# Experiments for  crackle match {0} THIS-FILE\n"
      "# Lengths, loads and times are strings with their units. File names are relative to this file.\n"
      "{1}\n"
      "# Nothing but loads? Then this line is enough, with a file of one column peak_load_N:\n"
      "#loads = \"loads.csv\"\n"
      "\n"
      "[[experiment]]\n"
      "name = \"specimen 1\"\n"
      "{2}"
      "{3}"
      "\n"
      "# Places of the crack's tip at some times, each in a table of its own:\n"
      "#[[experiment.tip]]\n"
      "#time = \"40 us\"\n"
      "#at = [\"12.25 mm\", \"70 mm\"]\n"
      "\n"
      "# Photographs, for the report:\n"
      "#[[experiment.picture]]\n"
      "#file = \"frame-40.png\"\n"
      "#time = \"40 us\"\n"
      "#scale = \"0.05 mm\"    # of a pixel\n"
      "#origin = [120, 480]   # pixels from the left and the top to the experiment's origin\n",
      folder, body_text(body, parameters), load_lines(samples),
      explained_experiment_keys({"name", "onset_load", "peak_load", "loads", "load_per_strength"}));
}

}  // namespace crackle::experiment
