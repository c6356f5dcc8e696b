// SPDX-License-Identifier: GPL-3.0-or-later
#include "crackle/analysis/sample_results.h"
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

void append_positions(std::string& text, const Statistics& statistics, const input::Sections& sections) {
  constexpr double to_mm = 1e3;
  auto out = std::back_inserter(text);
  fmt::format_to(out, "\ncrack positions, through-thickness mean [mm]; +- at {:g} % confidence{}\n",
                 100 * statistics.confidence,
                 statistics.n_looks > 1 ? fmt::format(" over {} looks", statistics.n_looks) : "");
  constexpr const char* form = "{:>5} {:>14} {:>5} {:>8} {:>10} {:>10} {:>10}\n";
  fmt::format_to(out, fmt::runtime(form), "notch", "section", "along", "reached", "mean", "std", "+-");
  const std::vector<input::Section> planes = sections.all();
  for (int notch = 0; notch < statistics.n_notches; ++notch) {
    for (std::size_t section = 0; section < planes.size(); ++section) {
      const auto p = static_cast<std::size_t>(notch) * planes.size() + section;
      fmt::format_to(out, fmt::runtime(form), notch, input::name_of(planes[section]),
                     planes[section].axis == 1 ? "z" : "y", statistics.reached[p],
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

/// Values of a result in the samples that are done, as people read them; without those that have none.
template <class Member>
std::vector<double> shown_values(std::span<const SampleSummary> samples, const ResultInfo& info,
                                 Member member) {
  std::vector<double> values;
  for (const SampleSummary& sample : samples) {
    const auto value = static_cast<double>(sample.*member);
    if (sample.status == SampleStatus::done && !std::isnan(value))
      values.push_back(value * info.shown_factor);
  }
  return values;
}

void append_shares(std::string& text, std::span<const SampleSummary> samples) {
  for_each_result([&](const ResultInfo& info, auto member) {
    if (info.reduction != Reduction::shares) return;
    auto out = std::back_inserter(text);
    const auto values = shown_values(samples, info, member);
    fmt::format_to(out, "\n{:<12}   samples\n", info.label);
    for (int k = 0; k < n_categories(info.categories); ++k)
      fmt::format_to(out, "{:<14} {:>7}\n", category_name(info.categories, k), std::ranges::count(values, k));
  });
}

void append_quantiles(std::string& text, std::span<const SampleSummary> samples) {
  fmt::format_to(std::back_inserter(text), "\n{:<30} {:>12} {:>12} {:>12} {:>12} {:>12}\n", "", "least",
                 "25 %", "median", "75 %", "greatest");
  for_each_result([&](const ResultInfo& info, auto member) {
    if (info.reduction != Reduction::quantiles) return;
    const auto values = shown_values(samples, info, member);
    if (values.empty()) return;
    auto out = std::back_inserter(text);
    const std::string units = *info.shown_units == 0 ? "" : fmt::format(" [{}]", info.shown_units);
    fmt::format_to(out, "{:<30}", info.label + units);
    const std::string form = fmt::format(" {{:>12{}}}", info.format);
    for (const double share : quantile_shares)
      fmt::format_to(out, fmt::runtime(form), quantile(values, share));
    text += '\n';
  });
}

}  // namespace

std::string to_text(const Statistics& statistics, std::span<const SampleSummary> samples,
                    const input::Sections& sections) {
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
  append_shares(text, samples);
  append_quantiles(text, samples);
  for (std::size_t i = 0; i < samples.size(); ++i) {
    auto out = std::back_inserter(text);
    if (!samples[i].error.empty())
      fmt::format_to(out, "\n{} {}: {}",
                     samples[i].status == SampleStatus::failed ? "failed sample" : "left sample", i,
                     samples[i].error);
    if (!samples[i].note.empty()) fmt::format_to(out, "\nsample {}: {}", i, samples[i].note);
  }
  if (text.back() != '\n') text += '\n';
  return text;
}

}  // namespace crackle::analysis
