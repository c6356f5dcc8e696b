// SPDX-License-Identifier: GPL-3.0-or-later
#include "crackle/analysis/statistics.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <iterator>

namespace crackle::analysis {

namespace {

/// A number, or a dash where there is none.
std::string number(double value, int decimals) {
  return std::isnan(value) ? "-" : fmt::format("{:.{}f}", value, decimals);
}

std::string plural(int n, const char* noun) {
  return fmt::format("{} {}{}", n, noun, n == 1 ? "" : "s");
}

void append_positions(std::string& text, const Statistics& statistics, std::span<const double> sections) {
  constexpr double to_mm = 1e3;
  auto out = std::back_inserter(text);
  fmt::format_to(out, "\ncrack positions z, through-thickness mean [mm]; +- at {:g} % confidence{}\n",
                 100 * statistics.confidence,
                 statistics.n_looks > 1 ? fmt::format(" over {} looks", statistics.n_looks) : "");
  fmt::format_to(out, "{:>5} {:>10} {:>8} {:>10} {:>10} {:>10}\n", "notch", "section y", "reached", "mean",
                 "std", "+-");
  for (int notch = 0; notch < statistics.n_notches; ++notch) {
    for (int section = 0; section < statistics.n_sections; ++section) {
      const auto p = static_cast<std::size_t>(notch * statistics.n_sections + section);
      fmt::format_to(out, "{:>5} {:>10} {:>8} {:>10} {:>10} {:>10}\n", notch,
                     number(sections[static_cast<std::size_t>(section)] * to_mm, 3), statistics.reached[p],
                     number(statistics.z_mean[p] * to_mm, 3), number(statistics.z_std[p] * to_mm, 3),
                     number(statistics.z_half_width[p] * to_mm, 3));
    }
  }
}

void append_patterns(std::string& text, const Statistics& statistics) {
  constexpr std::array<const char*, n_patterns> names{"none", "one crack", "two cracks", "other"};
  auto out = std::back_inserter(text);
  fmt::format_to(out, "\npattern        share [%]     +-\n");
  for (std::size_t k = 0; k < names.size(); ++k) {
    fmt::format_to(out, "{:<12} {:>11} {:>6}\n", names[k], number(100 * statistics.pattern_share[k], 1),
                   number(100 * statistics.pattern_half_width[k], 1));
  }
}

void append_quantiles(std::string& text, std::span<const SampleSummary> samples) {
  const auto append_row = [&](const char* name, double SampleSummary::*field, int decimals) {
    std::vector<double> values;
    for (const SampleSummary& sample : samples) {
      if (sample.status == SampleStatus::done) values.push_back(sample.*field);
    }
    auto out = std::back_inserter(text);
    fmt::format_to(out, "{:<20}", name);
    for (const double share : quantile_shares)
      fmt::format_to(out, " {:>12}", number(quantile(values, share), decimals));
    text += '\n';
  };
  fmt::format_to(std::back_inserter(text), "\n{:<20} {:>12} {:>12} {:>12} {:>12} {:>12}\n", "", "least",
                 "25 %", "median", "75 %", "greatest");
  append_row("onset force [N]", &SampleSummary::onset_force, 3);
  append_row("onset time [s]", &SampleSummary::onset_time, 6);
  append_row("crack speed [m/s]", &SampleSummary::crack_speed_max, 1);
  append_row("over Rayleigh's", &SampleSummary::crack_speed_ratio, 3);
  append_row("toughness [J/m^2]", &SampleSummary::effective_toughness, 3);
}

}  // namespace

std::string to_text(const Statistics& statistics, std::span<const SampleSummary> samples,
                    std::span<const double> sections) {
  const auto n_failed = std::count_if(samples.begin(), samples.end(), [](const SampleSummary& sample) {
    return sample.status == SampleStatus::failed;
  });
  std::string text =
      fmt::format("{}: {} done, {} failed, {} left\n", plural(statistics.n_needed, "sample"),
                  statistics.n_done, n_failed, statistics.n_needed - statistics.n_done - n_failed);
  if (statistics.n_needed < statistics.n_samples) {
    fmt::format_to(std::back_inserter(text), "stopped early: these are enough, of {}\n",
                   statistics.n_samples);
  }
  append_positions(text, statistics, sections);
  append_patterns(text, statistics);
  append_quantiles(text, samples);
  for (std::size_t i = 0; i < samples.size(); ++i) {
    if (samples[i].error.empty()) continue;
    fmt::format_to(std::back_inserter(text), "\n{} {}: {}",
                   samples[i].status == SampleStatus::failed ? "failed sample" : "left sample", i,
                   samples[i].error);
  }
  if (text.back() != '\n') text += '\n';
  return text;
}

}  // namespace crackle::analysis
