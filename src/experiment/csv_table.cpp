// SPDX-License-Identifier: GPL-3.0-or-later
#include "csv_table.h"

#include "crackle/common/printable.h"
#include "crackle/common/quantity_text.h"
#include "crackle/common/regular_file.h"
#include "input/document.h"
#include "input/units.h"

#include <fmt/format.h>

#include <algorithm>
#include <charconv>
#include <cmath>
#include <fstream>
#include <string_view>
#include <system_error>

namespace crackle::experiment {

namespace {

constexpr std::size_t max_errors = 10;

std::string cell_of(std::string_view text) {
  std::string cell(input::trimmed(text));
  while (!cell.empty() && cell.back() == '\r') cell.pop_back();
  cell = printable(cell);
  if (cell.size() >= 2 && cell.front() == '"' && cell.back() == '"') cell = cell.substr(1, cell.size() - 2);
  return cell;
}

std::vector<std::string> cells_of(std::string_view line, char separator) {
  std::vector<std::string> cells;
  for (std::size_t start = 0; start <= line.size();) {
    const std::size_t end = std::min(line.find(separator, start), line.size());
    cells.push_back(cell_of(line.substr(start, end - start)));
    start = end + 1;
  }
  return cells;
}

/// The separator of a header.
char separator_of(std::string_view header) {
  for (const char separator : {';', '\t'})
    if (header.find(separator) != std::string_view::npos) return separator;
  return ',';
}

void report_doubled(const std::vector<std::string>& header, int line, CsvErrors& errors) {
  for (auto name = header.begin(); name != header.end(); ++name)
    if (!name->empty() && std::find(header.begin(), name, *name) != name)
      errors.add(
          line, fmt::format("two columns are called \"{}\"; leave one of them out", input::shortened(*name)));
}

bool is_blank(std::string_view line) {
  return line.find_first_not_of(" \t\r,;") == std::string_view::npos;
}

}  // namespace

void CsvErrors::add(int line, const std::string& message) {
  // The rest is probably of the same kind.
  if (errors.size() < max_errors)
    errors.push_back(line > 0 ? fmt::format("line {}: {}", line, message) : message);
}

std::optional<std::size_t> CsvTable::column(const std::string& name) const {
  for (std::size_t i = 0; i < header.size(); ++i)
    if (header[i] == name) return i;
  return std::nullopt;
}

CsvTable read_csv(const std::filesystem::path& file, CsvErrors& errors) {
  CsvTable table;
  std::error_code error;
  if (!is_taken(file)) {
    errors.add(0, "there is no such file");
    return table;
  }
  if (const std::string kind = other_kind(file); !kind.empty()) {
    errors.add(0, "is " + kind);
    return table;
  }
  std::ifstream stream(file, std::ios::binary);
  if (!stream || std::filesystem::file_size(file, error) > max_csv_size || error) {
    errors.add(0, !stream || error ? "cannot be read" : fmt::format("is larger than {} bytes", max_csv_size));
    return table;
  }
  char separator = ',';
  int number = 0, block = 0;
  bool was_blank = false;
  for (std::string line; std::getline(stream, line);) {
    if (++number == 1) line = without_mark(line);
    if (line.find('\0') != std::string::npos) {
      errors.add(number, "not text in UTF-8, but perhaps in UTF-16; save the file as CSV in UTF-8");
      return table;
    }
    if (line.starts_with('#')) continue;
    if (is_blank(line)) {
      was_blank = true;
      continue;
    }
    if (table.header.empty()) {
      separator = separator_of(line);
      table.header = cells_of(line, separator);
      report_doubled(table.header, number, errors);
      was_blank = false;
      continue;
    }
    if (was_blank && !table.rows.empty()) ++block;
    was_blank = false;
    auto cells = cells_of(line, separator);
    if (cells.size() != table.header.size()) {
      errors.add(number, fmt::format("has {} under {}", count_text(cells.size(), "value"),
                                     count_text(table.header.size(), "heading")));
      continue;
    }
    table.rows.push_back({number, block, std::move(cells)});
  }
  if (table.header.empty()) errors.add(0, "is empty");
  return table;
}

std::optional<std::vector<double>> read_column(const CsvTable& table, const QuantityColumn& column,
                                               CsvErrors& errors) {
  const std::string prefix = column.name + "_";
  for (std::size_t i = 0; i < table.header.size(); ++i) {
    const std::string& heading = table.header[i];
    if (heading != column.name && !heading.starts_with(prefix)) continue;
    const std::string unit = heading == column.name ? "" : heading.substr(prefix.size());
    const input::Dimension& dimension = *column.dimension;
    const auto one = input::UnitSystem::shared().read("1 " + unit, dimension);
    if (one.error != input::QuantityError::none) {
      errors.add(0, fmt::format("the heading \"{}\" does not end in a unit of {}; write such as \"{}{}\"",
                                input::shortened(heading), dimension.name, prefix,
                                dimension.example.substr(dimension.example.find(' ') + 1)));
      return std::vector<double>(table.rows.size());
    }
    std::vector<double> values;
    for (const CsvTable::Row& row : table.rows) {
      const std::string& cell = row.cells[i];
      double value = 0;
      const char* const end = cell.data() + cell.size();
      const char* const begin = cell.data() + (cell.starts_with('+') ? 1 : 0);
      const auto [rest, status] = std::from_chars(begin, end, value);
      if (status != std::errc{} || rest != end || !std::isfinite(value)) {
        errors.add(row.line,
                   fmt::format("\"{}\" is not a number; write such as 12.5{}", input::shortened(cell),
                               cell.find(',') == std::string::npos ? "" : ", with a decimal point"));
        value = 0;
      }
      values.push_back(value * one.value);
    }
    return values;
  }
  return std::nullopt;
}

}  // namespace crackle::experiment
