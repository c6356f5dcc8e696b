// SPDX-License-Identifier: GPL-3.0-or-later
#include "result_attributes.h"

#include "common/failure.h"
#include "geometry/outline.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <cmath>
#include <type_traits>

namespace crackle::io {

using analysis::Reduction;

const analysis::ResultInfo status_info{"status",
                                       "",
                                       "state of the sample",
                                       analysis::About::computation,
                                       Reduction::none,
                                       analysis::nowhere,
                                       "status",
                                       "",
                                       1,
                                       "d",
                                       analysis::status_categories};
const analysis::ResultInfo wall_time_info{"wall_time",
                                          "s",
                                          "wall time that the sample took",
                                          analysis::About::computation,
                                          Reduction::none,
                                          analysis::nowhere,
                                          "wall time",
                                          "s",
                                          1,
                                          ".1f"};

void describe_result(hid_t parent, const std::string& dataset, const analysis::ResultInfo& info, int column) {
  const hdf5::Handle object = hdf5::open_dataset(parent, dataset);
  hdf5::write_attribute(object, "column", std::int64_t{column});
  hdf5::write_attribute(object, "meaning", info.meaning);
  hdf5::write_attribute(object, "label", info.label);
  hdf5::write_attribute(object, "shown_units", info.shown_units);
  hdf5::write_attribute(object, "shown_factor", info.shown_factor);
  hdf5::write_attribute(object, "format", info.format);
  if (*info.categories != 0) hdf5::write_attribute(object, "categories", info.categories);
}

void describe_dataset(hid_t parent, const std::string& dataset, const std::string& meaning) {
  hdf5::write_attribute(hdf5::open_dataset(parent, dataset), "meaning", meaning);
}

void describe_parts(hid_t group, const std::vector<std::string>& parts, int column) {
  const analysis::ResultInfo& info = analysis::crack_area_in_info;
  describe_result(group, info.name, info, column);
  const hdf5::Handle dataset = hdf5::open_dataset(group, info.name);
  hdf5::write_attribute(dataset, "parts", fmt::format("{}", fmt::join(parts, "\n")));
  std::vector<std::string> dimensions{"part"};
  if (hdf5::read_shape(group, info.name).size() > 1) dimensions.insert(dimensions.begin(), "sample");
  hdf5::label_dimensions(dataset, dimensions);
}

std::vector<std::string> random_keys(const std::vector<input::RandomInput>& random) {
  std::vector<std::string> keys;
  for (const input::RandomInput& one : random) keys.push_back(one.key);
  return keys;
}

void write_random_keys(hid_t group, const std::vector<input::RandomInput>& random) {
  hdf5::write_attribute(group, "keys", fmt::format("{}", fmt::join(random_keys(random), "\n")));
}

std::string units_of(const input::RandomInput& random) {
  return random.unit.empty() ? "1" : random.unit;
}

void check_numbers(const analysis::SampleSummary& row, const std::vector<std::string>& random_keys,
                   const std::string& name) {
  const auto refuse_infinite = [&](const char* result, double value) {
    if (std::isinf(value)) fail<hdf5::Error>("{}{} is infinite", name, result);
  };
  for (std::size_t k = 0; k < row.inputs.size() && row.status == analysis::SampleStatus::done; ++k)
    if (!std::isfinite(row.inputs[k]))
      fail<hdf5::Error>("{}the random input {} is {}", name, random_keys.at(k), row.inputs[k]);
  analysis::for_each_result([&](const analysis::ResultInfo& info, auto member) {
    refuse_infinite(info.name, static_cast<double>(row.*member));
  });
  analysis::for_each_position_result([&](const analysis::ResultInfo& info, auto member) {
    for (const auto value : row.*member) refuse_infinite(info.name, static_cast<double>(value));
  });
  analysis::for_each_trace_result([&](const analysis::ResultInfo& info, auto member) {
    for (const cracks::StartTrace& trace : row.traces) refuse_infinite(info.name, trace.*member);
  });
  analysis::for_each_fragment_result([&](const analysis::ResultInfo& info, auto member) {
    refuse_infinite(info.name, row.fragments.*member);
  });
  for (const double number : row.fragments.heavier) refuse_infinite("heavier", number);
  for (const double area : row.crack_area_in) refuse_infinite(analysis::crack_area_in_info.name, area);
}

void write_specimen(hid_t file, const geometry::Body& body, std::span<const plane::PreCrack> flaws) {
  const hdf5::Handle group = hdf5::create_group(file, "specimen");
  geometry::for_each_member(
      geometry::outline_of(body, flaws),
      [&](const char* name, const auto& shape, const auto& values, const char* units, const char* meaning) {
        using Value = typename std::remove_cvref_t<decltype(values)>::value_type;
        if constexpr (std::is_same_v<Value, std::string>)
          hdf5::write_texts(group, name, values);
        else
          hdf5::write_dataset<Value>(group, name, hdf5::Shape(shape.begin(), shape.end()), values, units);
        describe_dataset(group, name, meaning);
      });
}

}  // namespace crackle::io
