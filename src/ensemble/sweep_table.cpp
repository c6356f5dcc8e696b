// SPDX-License-Identifier: GPL-3.0-or-later
#include "ensemble/sweep_table.h"

#include "analysis/censored_values.h"
#include "analysis/grouped_values.h"
#include "analysis/result_list.h"
#include "analysis/statistics.h"
#include "common/failure.h"
#include "common/index.h"
#include "common/real.h"
#include "common/regular_file.h"
#include "common/text_table.h"
#include "common/whole_number.h"
#include "cracks/crack_pattern.h"
#include "ensemble/results.h"

#include <fmt/format.h>
#include <fmt/ranges.h>
#include <nlohmann/json.hpp>

#include <algorithm>
#include <cmath>
#include <stdexcept>
#include <string_view>
#include <system_error>
#include <type_traits>

namespace crackle::ensemble {

namespace fs = std::filesystem;

fs::path sweep_input(const fs::path& folder) {
  return folder / "sweep.toml";
}

fs::path sweep_table(const fs::path& folder) {
  return folder / "summary.csv";
}

fs::path case_folder(const fs::path& folder, std::size_t number, std::size_t n_cases) {
  const auto n_digits = std::to_string(n_cases - 1).size();
  return folder / fmt::format("case-{:0{}}", number, n_digits);
}

void check_sweep_folder(const fs::path& folder, std::size_t n_cases, bool is_resumed) {
  if (is_taken(folder / "input.toml") || is_taken(results_file(folder)))
    fail("'{}' holds an ensemble; use another folder for the sweep", folder.string());
  require_regular(sweep_input(folder));
  require_regular(sweep_table(folder));
  if (is_taken(sweep_input(folder)) && !is_resumed)
    fail("'{}' already holds a sweep; continue it with --resume, or use another folder", folder.string());
  std::error_code ignored;
  for (const auto& entry : fs::directory_iterator(folder, ignored)) {
    const std::string name = entry.path().filename().string();
    if (!name.starts_with("case-")) continue;
    const auto number = whole_number<std::size_t>(std::string_view(name).substr(5));
    if (!number || *number >= n_cases || entry.path() != case_folder(folder, *number, n_cases))
      fail("'{}' holds {}, but the sweep has {} cases; use another folder", folder.string(), name, n_cases);
  }
}

namespace {

using analysis::ResultInfo;
using analysis::SampleSummary;

constexpr int not_a_share = -2, any = -1;

/// One column of the table: a mean, or the share of samples in a category, with its interval.
struct Cell {
  ResultInfo info;
  int category = not_a_share;
  double value = not_a_number, lower = not_a_number, upper = not_a_number;
  bool is_of_broken = false;  ///< some samples did not break, of which it is not

  bool is_share() const { return category != not_a_share; }
  /// The word for the samples that the share counts.
  std::string share_of() const {
    if (!is_share()) return {};
    return category == any ? "any" : analysis::category_name(info.categories, category);
  }
};

/// @param values of the samples that have the result, by draws of the random inputs
Cell share_cell(const ResultInfo& info, int category, const analysis::CensoredValues& values) {
  Cell cell{info, category};
  if (values.size() == 0) return cell;
  std::vector<double> hits;
  for (const double value : values.value)
    hits.push_back((category == any ? value > 0 : value == category) ? 1 : 0);
  const auto interval = analysis::share_interval(hits, values.group, analysis::default_confidence);
  cell.value = static_cast<double>(std::ranges::count(hits, 1.0)) / static_cast<double>(hits.size());
  cell.lower = interval.lower;
  cell.upper = interval.upper;
  return cell;
}

template <class Number>
void add_cells(const ResultInfo& info, Number SampleSummary::*member, std::span<const SampleSummary> rows,
               int replicates, std::vector<Cell>& cells) {
  analysis::CensoredValues values;
  for (std::size_t i = 0; i < rows.size(); ++i)
    values.add({analysis::known(info, member, rows[i])}, i / index(replicates));
  const int n_categories = analysis::n_categories(info.categories);
  for (int k = 0; k < n_categories; ++k) cells.push_back(share_cell(info, k, values));
  if (n_categories > 0) return;
  const auto [mean, deviation, half] =
      analysis::mean_estimate(values.value, values.group, analysis::default_confidence);
  const bool is_of_broken =
      std::ranges::any_of(rows, [&](const SampleSummary& row) { return analysis::is_open(info, row); });
  cells.push_back({info, not_a_share, mean, mean - half, mean + half, is_of_broken});
  if (info.reduction == analysis::Reduction::counts) cells.push_back(share_cell(info, any, values));
}

/// @param replicates samples with the same draw of the random inputs
std::vector<Cell> cells_of(std::span<const SampleSummary> rows, int replicates) {
  std::vector<Cell> cells;
  analysis::for_each_result(
      [&](const ResultInfo& info, auto member) { add_cells(info, member, rows, replicates, cells); });
  return cells;
}

std::vector<Cell> cells_of(const CaseRows& one) {
  return cells_of(one.rows, one.of->parameters.ensemble.replicates);
}

int count(std::span<const SampleSummary> rows, analysis::SampleStatus status) {
  return static_cast<int>(std::ranges::count(rows, status, &SampleSummary::status));
}

/// A field of a CSV file, in quotes.
std::string quoted(const std::string& text) {
  std::string result = "\"";
  for (const char c : text) result += c == '"' ? "\"\"" : std::string(1, c);
  return result + '"';
}

std::string number_or_nothing(double value) {
  return std::isnan(value) ? std::string() : fmt::format("{:.10g}", value);
}

/// Those that say how samples broke, and of which `crackle stats` prints means or shares.
std::vector<Cell> of_bodies(std::vector<Cell> cells) {
  using enum analysis::Reduction;
  std::erase_if(cells, [](const Cell& cell) {
    const bool is_printed = cell.is_share() || cell.info.reduction == counts ||
                            (cell.info.reduction == quantiles && cell.info.about != analysis::About::place);
    return !is_printed || cell.info.about == analysis::About::computation;
  });
  return cells;
}

/// True for a column of the text table: of counts the share of samples with any, of patterns two cracks.
bool is_shown(const Cell& cell) {
  if ((cell.info.short_tables & analysis::in_sweep) == 0) return false;
  if (cell.info.reduction == analysis::Reduction::counts) return cell.is_share();
  return !cell.is_share() || cell.category == static_cast<int>(cracks::Pattern::two_cracks);
}

/// With so many significant digits; all before the point of a large number.
std::string without_exponent(double value, int n_digits) {
  const std::string text = fmt::format("{:.{}g}", value, n_digits);
  return std::abs(value) >= 1 && text.find('e') != std::string::npos ? fmt::format("{:.0f}", value) : text;
}

/// True for a value with an asterisk.
bool is_marked(const Cell& cell) {
  return cell.is_of_broken && !std::isnan(cell.value);
}

std::string shown_value(const Cell& cell, double factor) {
  if (std::isnan(cell.value)) return "-";
  const std::string value = without_exponent(factor * cell.value, 4) + (is_marked(cell) ? "*" : "");
  if (std::isnan(cell.lower)) return value;
  if (cell.is_share())
    return fmt::format("{} ({:.0f}-{:.0f})", value, factor * cell.lower, factor * cell.upper);
  return fmt::format("{} +- {}", value, without_exponent(factor * (cell.upper - cell.value), 2));
}

}  // namespace

std::string sweep_csv(std::span<const CaseRows> cases) {
  std::vector<std::string> lines;
  for (std::size_t i = 0; i < cases.size(); ++i) {
    const CaseRows& one = cases[i];
    const auto cells = cells_of(one);
    if (i == 0) {
      std::vector<std::string> head{"case", "folder"};
      for (const auto& setting : one.of->settings) head.push_back(quoted(setting.key));
      head.insert(head.end(), {"samples", "done", "failed", "unbroken"});
      for (const Cell& cell : cells) {
        const std::string units =
            cell.is_share() || *cell.info.units == 0 ? "" : fmt::format(" [{}]", cell.info.units);
        const std::string share = cell.is_share() ? ": " + cell.share_of() : "";
        for (const char* const what : {"", " lower", " upper"})
          head.push_back(quoted(cell.info.name + share + units + what));
      }
      lines.push_back(fmt::format("{}", fmt::join(head, ",")));
    }
    std::vector<std::string> line{std::to_string(i), one.folder};
    for (const auto& setting : one.of->settings) line.push_back(quoted(setting.value));
    line.push_back(std::to_string(one.rows.size()));
    for (const auto status : {analysis::SampleStatus::done, analysis::SampleStatus::failed})
      line.push_back(std::to_string(count(one.rows, status)));
    line.push_back(std::to_string(std::ranges::count_if(one.rows, analysis::is_unbroken)));
    for (const Cell& cell : cells)
      for (const double value : {cell.value, cell.lower, cell.upper})
        line.push_back(number_or_nothing(value));
    lines.push_back(fmt::format("{}", fmt::join(line, ",")));
  }
  return fmt::format("{}\n", fmt::join(lines, "\n"));
}

std::string sweep_text(std::span<const CaseRows> cases) {
  std::vector<std::vector<Cell>> cells;
  for (const CaseRows& one : cases) cells.push_back(cells_of(one));
  TextTable table{{"case", "done", "failed"}};
  for (std::size_t i = 0; i < cases.size(); ++i)
    table.push_back({std::to_string(i), std::to_string(count(cases[i].rows, analysis::SampleStatus::done)),
                     std::to_string(count(cases[i].rows, analysis::SampleStatus::failed))});
  bool any_is_of_broken = false;
  const std::vector<Cell> heads = cells_of({}, 1);
  for (std::size_t k = 0; k < heads.size(); ++k) {
    const Cell& head = heads[k];
    if (!is_shown(head)) continue;
    double largest = 0;
    for (const auto& of_case : cells)
      if (const double value = std::abs(of_case[k].value); value > largest) largest = value;
    const ShownUnit unit = head.is_share() ? ShownUnit{"%", 100} : head.info.unit_for(largest);
    table[0].push_back(with_unit(head.category >= 0 ? head.share_of() : head.info.label, unit.name));
    for (std::size_t i = 0; i < cases.size(); ++i) {
      table[i + 1].push_back(shown_value(cells[i][k], unit.factor));
      any_is_of_broken |= is_marked(cells[i][k]);
    }
  }
  const bool peak_is_first = std::ranges::any_of(cases, [](const CaseRows& one) {
    return analysis::headline_load(one.rows) == std::string_view("peak_load");
  });
  for (auto& row : table)
    if (peak_is_first) std::swap(row[3], row[4]);  // the onset force and the peak load
  table[0].push_back("settings");
  for (std::size_t i = 0; i < cases.size(); ++i) table[i + 1].push_back(to_string(cases[i].of->settings));
  std::string text = aligned(table, 0, true);
  if (any_is_of_broken)
    text +=
        "*: of the samples that broke, and were not held; crackle stats of a case estimates the loads of "
        "all\n";
  return text;
}

std::string sweep_json(std::span<const CaseRows> cases) {
  using Json = nlohmann::ordered_json;
  Json document{
      {"confidence", analysis::default_confidence}, {"results", Json::array()}, {"cases", Json::array()}};
  for (const Cell& cell : of_bodies(cells_of({}, 1))) {
    document["results"].push_back({{"name", cell.info.name},
                                   {"label", cell.info.label},
                                   {"share_of", cell.share_of()},
                                   {"shown_units", cell.is_share() ? "%" : cell.info.shown_units},
                                   {"shown_factor", cell.is_share() ? 100 : cell.info.shown_factor}});
  }
  for (const CaseRows& one : cases) {
    Json row{{"folder", one.folder},
             {"settings", Json::array()},
             {"n_samples", one.rows.size()},
             {"n_done", count(one.rows, analysis::SampleStatus::done)},
             {"n_failed", count(one.rows, analysis::SampleStatus::failed)},
             {"n_unbroken", std::ranges::count_if(one.rows, analysis::is_unbroken)}};
    for (const auto& [key, value] : one.of->settings)
      row["settings"].push_back({{"key", key}, {"value", value}});
    for (const Cell& cell : of_bodies(cells_of(one))) {
      row["value"].push_back(cell.value);
      row["lower"].push_back(cell.lower);
      row["upper"].push_back(cell.upper);
    }
    document["cases"].push_back(std::move(row));
  }
  return document.dump(-1, ' ', false, Json::error_handler_t::replace) + "\n";
}

}  // namespace crackle::ensemble
