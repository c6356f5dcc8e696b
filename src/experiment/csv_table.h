// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "input/dimension.h"

#include <cstddef>
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

namespace crackle::experiment {

/// A table of comma-, semicolon- or tab-separated values: a header, then rows of as many cells. Lines that
/// begin with # are comments.
struct CsvTable {
  struct Row {
    int line;   ///< number in the file, from 1
    int block;  ///< number of the blank lines before it, counting neighbouring ones once
    std::vector<std::string> cells;
  };
  std::vector<std::string> header;
  std::vector<Row> rows;

  std::optional<std::size_t> column(const std::string& name) const;
};

/// Files are no larger than this, which leaves room for a curve of a million points.
inline constexpr std::size_t max_csv_size = std::size_t{1} << 25;

/// A file or a table could not be read completely; `errors` then has a line for each reason, "3: ..." with
/// the number of the line it is about.
struct CsvErrors {
  std::vector<std::string> errors;
  void add(int line, const std::string& message);
  bool empty() const { return errors.empty(); }
};

/// Rows with a wrong number of cells are reported and left out.
CsvTable read_csv(const std::filesystem::path& file, CsvErrors& errors);

/// A column of quantities and its unit in the header: "y_mm", "load_kN".
struct QuantityColumn {
  std::string name;  ///< "y"
  const input::Dimension* dimension;
};

/// The values of a column in SI units; empty if the table has no such column. A column whose unit is missing
/// or of another dimension, and a cell that is not a number, are reported; the cell is then 0.
std::optional<std::vector<double>> read_column(const CsvTable& table, const QuantityColumn& column,
                                               CsvErrors& errors);

}  // namespace crackle::experiment
