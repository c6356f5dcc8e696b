// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "cracks/crack_history.h"
#include "dynamics/sample_result.h"
#include "input/model.h"

#include "hdf5.h"
#include "result_attributes.h"

#include <functional>
#include <string>
#include <tuple>
#include <type_traits>
#include <utility>
#include <vector>

namespace crackle::io {

/// Appends the extents of nested fixed-size arrays; none for a number.
template <class Value>
void add_extents(hdf5::Shape& shape) {
  if constexpr (!std::is_arithmetic_v<Value>) {
    shape.push_back(std::tuple_size_v<Value>);
    add_extents<typename Value::value_type>(shape);
  }
}

/// Writes one column of a table: `value_of` applied to every row, a number or an array.
template <class Value, class Row, class Of>
void write_column(hid_t group, const std::string& name, const std::vector<Row>& rows, Of value_of,
                  const std::string& units = "", const std::string& meaning = "") {
  std::vector<Value> column;
  for (const Row& row : rows) hdf5::flatten(std::invoke(value_of, row), column);
  hdf5::Shape shape{rows.size()};
  add_extents<std::remove_cvref_t<std::invoke_result_t<Of, const Row&>>>(shape);
  hdf5::write_dataset<Value>(group, name, shape, column, units, hdf5::Storage::compressed);
  if (!meaning.empty()) describe_dataset(group, name, meaning);
}

/// Writes the group /history of a sample file: one row for each moment.
/// @param separated_at as in SampleResult
/// @param cracks of the same rows; empty tables without analysis
void write_history(hid_t file, const input::Model& model, const std::vector<input::Probe>& probes,
                   const std::vector<dynamics::HistoryRow>& rows, double separated_at,
                   const cracks::CrackHistory& cracks);

}  // namespace crackle::io
