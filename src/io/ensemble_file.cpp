// SPDX-License-Identifier: GPL-3.0-or-later
#include "io/ensemble_file.h"

#include "common/failure.h"
#include "common/packing.h"
#include "common/regular_file.h"
#include "input/reader.h"
#include "parallel/agreement.h"
#include "parallel/collectives.h"
#include "parallel/petsc.h"

#include "hdf5.h"
#include "partial_file.h"
#include "provenance.h"
#include "result_attributes.h"

#include <fmt/format.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <cstring>
#include <optional>
#include <stdexcept>
#include <type_traits>

namespace crackle::io {

// How the file is written: the root lays it out in memory, with every object, every attribute and the rows of
// pending samples, and writes that to the partial file in one piece. Then all ranks open the file through
// MPI-IO and write their rows into preallocated datasets. Hence no rank changes the file's structure in
// parallel, the file does not depend on the ranks, and a full disk is detected on the root before any
// collective call. The transfers are independent: they are a few kilobytes per rank, and Open MPI's
// collective writes (OMPIO's fcoll components) have hung.

namespace {

using analysis::ResultInfo;
using analysis::SampleSummary;
using hdf5::Shape;

std::int32_t status_of(const SampleSummary& row) {
  return static_cast<std::int32_t>(row.status);
}

/// Calls visit(dataset, info, value of a row) for every dataset with one value per sample.
template <class Visit>
void for_each_column(Visit&& visit) {
  visit("samples/status", status_info, status_of);
  analysis::for_each_result([&](const ResultInfo& info, auto member) {
    visit(std::string("samples/") + info.name, info,
          [member](const SampleSummary& row) { return row.*member; });
  });
  visit("timing/wall_time", wall_time_info, [](const SampleSummary& row) { return row.wall_time; });
}

struct EnsembleShape {
  std::size_t n_samples;
  std::size_t n_starts;
  std::size_t n_sections;
  std::size_t n_y_sections;  ///< these come first
  std::vector<std::string> random_keys;
  std::size_t n_parts;  ///< analysis::crack_parts
  std::size_t n_planes;
  std::size_t n_trace_rows;  ///< of each plane
  std::size_t n_positions() const { return n_starts * n_sections; }
};

EnsembleShape shape_of(const input::Study& study) {
  return {static_cast<std::size_t>(study.ensemble.samples),
          geometry::n_crack_starts(study),
          study.sections.size(),
          study.sections.y.size(),
          random_keys(study.random),
          analysis::crack_parts(study.materials, study.interfaces).size(),
          study.sections.planes.size(),
          cracks::n_trace_rows(geometry::n_crack_starts(study))};
}

/// One of a row's values, which may not be known yet: then NaN.
double value_or_none(const std::vector<double>& values, std::size_t k) {
  return k < values.size() ? values[k] : SampleSummary::none;
}

const ResultInfo y_position_info{"z",
                                 "m",
                                 "position at the sections y = const",
                                 analysis::About::path,
                                 analysis::Reduction::none,
                                 analysis::nowhere,
                                 "z",
                                 "mm",
                                 1e3,
                                 ".3f"};

/// Calls visit(dataset, info, sections, values of a row) for every dataset with notches x sections values per
/// sample.
template <class Visit>
void for_each_position_table(const EnsembleShape& shape, Visit&& visit) {
  analysis::for_each_position_result([&](const ResultInfo& info, auto member) {
    visit(
        std::string("crack_path/") + info.name, info,
        shape.n_sections, [member](const SampleSummary& row) -> auto& { return row.*member; });
  });
  visit("crack_path/z", y_position_info, shape.n_y_sections, [shape](const SampleSummary& row) {
    std::vector<double> z;
    for (std::size_t start = 0; start < shape.n_starts; ++start) {
      const auto first = row.position.begin() + static_cast<std::ptrdiff_t>(start * shape.n_sections);
      z.insert(z.end(), first, first + static_cast<std::ptrdiff_t>(shape.n_y_sections));
    }
    return z;
  });
}

void check_block(const EnsembleBlock& block, const EnsembleShape& shape) {
  if (block.first > shape.n_samples || block.rows.size() > shape.n_samples - block.first) {
    fail<std::invalid_argument>("ensemble rows {} to {}: the ensemble has {} samples", block.first,
                                block.first + block.rows.size(), shape.n_samples);
  }
  for (std::size_t i = 0; i < block.rows.size(); ++i) {
    const SampleSummary& row = block.rows[i];
    analysis::for_each_position_result([&](const ResultInfo& info, auto member) {
      if ((row.*member).size() == shape.n_positions()) return;
      fail<std::invalid_argument>("ensemble row {}: {} values {} instead of {} notches x {} sections",
                                  block.first + i, (row.*member).size(), info.name, shape.n_starts,
                                  shape.n_sections);
    });
  }
}

/// Verifies that blocks do not overlap. Collective; every rank sees all blocks, so all ranks agree on the
/// result.
void check_disjoint(const parallel::Communicator& world, const EnsembleBlock& block) {
  using Rows = std::array<std::size_t, 2>;  // first, number
  const Rows mine{block.first, block.rows.size()};
  auto blocks = parallel::gather_all<Rows>(world, {&mine, 1});
  std::erase_if(blocks, [](const Rows& some) { return some[1] == 0; });
  std::sort(blocks.begin(), blocks.end());
  std::optional<std::string> error;
  for (std::size_t i = 0; i + 1 < blocks.size(); ++i) {
    if (blocks[i][0] + blocks[i][1] > blocks[i + 1][0])
      error = fmt::format("ensemble row {} is held by two ranks", blocks[i + 1][0]);
  }
  parallel::agree_on_error(world, error);
}

/// One text per sample, on the root. Collective.
std::vector<std::string> gather_texts(const parallel::Communicator& world, const EnsembleBlock& block,
                                      std::string SampleSummary::*text, std::size_t n_samples) {
  const auto packed = parallel::agree(world, [&] {
    Packer packer;
    for (std::size_t i = 0; i < block.rows.size(); ++i) {
      if ((block.rows[i].*text).empty()) continue;
      packer.put<std::uint64_t>(block.first + i);
      packer.put(block.rows[i].*text);
    }
    return packer.bytes();
  });
  const auto gathered = parallel::gather_bytes_on_root(world, packed, "the errors and notes of all samples");
  return parallel::agree(world, [&] {
    std::vector<std::string> texts(n_samples);
    Unpacker unpacker(gathered);
    while (!unpacker.empty()) {
      const auto sample = unpacker.get<std::uint64_t>();
      texts[sample] = unpacker.get<std::string>();
    }
    return texts;
  });
}

/// @param n_rows of the positions
void write_paths(hid_t id, const analysis::PathStatistics& paths, std::size_t n_rows,
                 const EnsembleShape& shape) {
  const Shape positions{n_rows, shape.n_sections};
  hdf5::write_dataset<double>(id, "z_mean", positions, paths.z_mean, "m");
  hdf5::write_dataset<double>(id, "z_std", positions, paths.z_std, "m");
  hdf5::write_dataset<double>(id, "z_half_width", positions, paths.z_half_width, "m");
  hdf5::write_dataset<double>(id, "z_quantile", {n_rows, shape.n_sections, analysis::quantile_shares.size()},
                              paths.z_quantile, "m");
  hdf5::write_dataset<std::int32_t>(id, "reached", positions, paths.reached, "");
  hdf5::write_dataset<double>(id, "running_mean", {shape.n_samples, n_rows, shape.n_sections},
                              paths.running_mean, "m");
}

void write_trace_statistics(hid_t statistics, const std::vector<analysis::TraceStatistics>& traces,
                            const EnsembleShape& shape) {
  if (shape.n_planes == 0) return;
  using analysis::TraceStatistics;
  const hdf5::Handle group = hdf5::create_group(statistics, "traces");
  const auto write = [&](const std::string& name, const char* units, auto&& value_of) {
    std::vector<std::decay_t<decltype(value_of(traces.front()))>> values;
    for (const TraceStatistics& one : traces) values.push_back(value_of(one));
    hdf5::write_dataset<typename decltype(values)::value_type>(
        group, name, {shape.n_planes, shape.n_trace_rows}, values, units);
  };
  write("crossed", "", [](const TraceStatistics& one) { return std::int32_t{one.n_crossed}; });
  write("share", "1", [](const TraceStatistics& one) { return one.share; });
  write("share_lower", "1", [](const TraceStatistics& one) { return one.interval.lower; });
  write("share_upper", "1", [](const TraceStatistics& one) { return one.interval.upper; });
  std::size_t i = 0;
  analysis::for_each_trace_result([&](const ResultInfo& info, auto) {
    for_each_part_of_estimate([&](const char* what, auto member) {
      write(fmt::format("{}_{}", info.name, what), info.units,
            [i, member](const TraceStatistics& one) { return one.results[i].*member; });
    });
    ++i;
  });
  hdf5::label_datasets(group, {"plane", "cracks"});
}

/// Calls visit(name's ending, member) for the parts of an estimate.
template <class Visit>
void for_each_part_of_estimate(Visit&& visit) {
  using Estimate = analysis::MeanEstimate;
  visit("mean", &Estimate::mean);
  visit("std", &Estimate::std);
  visit("half_width", &Estimate::half_width);
}

void write_fragment_statistics(hid_t statistics, const analysis::FragmentStatistics& fragments) {
  const hdf5::Handle group = hdf5::create_group(statistics, "fragments");
  hdf5::write_scalar<std::int32_t>(group, "counted", fragments.n_of, "");
  describe_dataset(group, "counted", "samples whose fragments are known");
  hdf5::write_scalar<std::int32_t>(group, "fragmented", fragments.n_fragmented, "");
  describe_dataset(group, "fragmented", "of these, samples with more than two, see analysis::is_fragmented");
  for_each_part_of_estimate([&](const char* part, auto member) {
    std::size_t i = 0;
    analysis::for_each_fragment_result([&](const ResultInfo& info, auto) {
      hdf5::write_scalar<double>(group, fmt::format("{}_{}", info.name, part), fragments.results[i++].*member,
                                 info.units);
    });
    std::vector<double> values(analysis::fragment_shares().size(), SampleSummary::none);
    std::ranges::transform(fragments.heavier, values.begin(), member);
    hdf5::write_dataset<double>(group, fmt::format("heavier_{}", part), {values.size()}, values, "");
    hdf5::label_dimensions(hdf5::open_dataset(group, fmt::format("heavier_{}", part)),
                           std::vector<std::string>{"share"});
  });
}

void write_statistics(hid_t file, const analysis::Statistics& statistics, const EnsembleShape& shape) {
  const hdf5::Handle group = hdf5::create_group(file, "statistics");
  hdf5::write_attribute(group, "confidence", statistics.confidence);
  hdf5::write_attribute(group, "interval_scope",
                        analysis::interval_scope(statistics.base, statistics.replicates));
  hdf5::write_attribute(group, "n_looks", std::int64_t{statistics.n_looks});
  hdf5::write_attribute(group, "n_needed", std::int64_t{statistics.n_needed});
  write_paths(group, statistics, shape.n_starts, shape);
  for (const auto& [name, values] : {std::pair{"pattern_share", &statistics.pattern_share},
                                     {"pattern_half_width", &statistics.pattern_half_width},
                                     {"pattern_lower", &statistics.pattern_lower},
                                     {"pattern_upper", &statistics.pattern_upper}})
    hdf5::write_dataset<double>(group, name, {analysis::n_patterns}, *values, "1");
  hdf5::write_dataset<std::int32_t>(group, "reference_notch", {shape.n_starts}, statistics.reference_start,
                                    "");
  analysis::for_each_rank(statistics, [&](const std::string& name, const analysis::RankStatistics& ranks) {
    const hdf5::Handle of_rank = hdf5::create_group(group, name);
    const std::size_t n_rows = ranks.start.size();
    hdf5::write_dataset<std::int32_t>(of_rank, "leading_notch", {n_rows}, ranks.leading_start, "");
    hdf5::write_dataset<std::int32_t>(of_rank, "notch", {n_rows}, ranks.start, "");
    hdf5::write_dataset<std::int32_t>(of_rank, "counted", {n_rows, shape.n_sections}, ranks.counted, "");
    write_paths(of_rank, ranks, n_rows, shape);
  });
  write_trace_statistics(group, statistics.traces, shape);
  write_fragment_statistics(group, statistics.fragments);
}

/// The shares at which fragments are counted, and the numbers of pending samples.
void lay_out_fragments(hid_t file, const EnsembleShape& shape) {
  const hdf5::Handle group = hdf5::create_group(file, "fragments");
  const std::vector<double> pending(shape.n_samples, SampleSummary::none);
  analysis::for_each_fragment_result([&](const ResultInfo& info, auto) {
    hdf5::write_dataset<double>(group, info.name, {shape.n_samples}, pending, info.units);
    describe_dataset(group, info.name, info.meaning);
  });
  const std::vector<double> shares = analysis::fragment_shares();
  const std::vector<double> table(shape.n_samples * shares.size(), SampleSummary::none);
  hdf5::write_dataset<double>(group, "heavier", {shape.n_samples, shares.size()}, table, "");
  describe_dataset(group, "heavier", analysis::heavier_meaning);
  hdf5::label_datasets(group, {"sample", "share"});
  hdf5::write_dataset<double>(group, "shares", {shares.size()}, shares, "1");
  describe_dataset(group, "shares", "of the body's mass");
  hdf5::label_dimensions(hdf5::open_dataset(group, "shares"), std::vector<std::string>{"share"});
}

/// The planes, which rows of traces are whose, and the traces of pending samples.
void lay_out_traces(hid_t file, const input::Study& study, const std::vector<std::string>& start_names,
                    const EnsembleShape& shape) {
  if (shape.n_planes == 0) return;
  const hdf5::Handle group = hdf5::create_group(file, "plane_traces");
  const std::vector<double> pending(shape.n_samples * shape.n_planes * shape.n_trace_rows,
                                    SampleSummary::none);
  analysis::for_each_trace_result([&](const ResultInfo& info, auto) {
    hdf5::write_dataset<double>(group, info.name, {shape.n_samples, shape.n_planes, shape.n_trace_rows},
                                pending, info.units);
    describe_dataset(group, info.name, info.meaning);
  });
  hdf5::label_datasets(group, {"sample", "plane", "cracks"});
  std::vector<double> point, normal, axes;
  for (const input::SectionPlane& plane : study.sections.planes) {
    point.insert(point.end(), plane.point.begin(), plane.point.end());
    normal.insert(normal.end(), plane.normal.begin(), plane.normal.end());
    for (const Vector& axis : cracks::axes_along(plane)) axes.insert(axes.end(), axis.begin(), axis.end());
  }
  hdf5::write_dataset<double>(group, "point", {shape.n_planes, 3}, point, "m");
  hdf5::write_dataset<double>(group, "normal", {shape.n_planes, 3}, normal, "1");
  hdf5::write_dataset<double>(group, "axes", {shape.n_planes, 2, 3}, axes, "1");
  std::vector<std::string> cracks = start_names;
  cracks.insert(cracks.end(), {"without a start", "all"});
  hdf5::write_texts(group, "cracks", cracks);
}

void write_mother_points(hid_t file, const geometry::MotherPoints& base) {
  const hdf5::Handle group = hdf5::create_group(file, "mother_points");
  std::vector<double> position;
  hdf5::flatten(base.position, position);
  hdf5::write_dataset<double>(group, "position", {base.size(), 3}, position, "m");
  hdf5::write_dataset<double>(group, "spacing", {base.size()}, base.spacing, "m");
  hdf5::write_dataset<std::uint8_t>(group, "movable", {base.size()}, base.movable, "");
}

void write_sections(hid_t file, const input::Sections& sections) {
  std::vector<double> position;
  std::vector<std::int32_t> axis;
  std::vector<double> lines;
  for (const input::Section& section : sections.all()) {
    position.push_back(section.position);
    axis.push_back(section.axis);
    if (section.axis != 0) continue;
    for (const auto& end : {section.line.from, section.line.to})
      lines.insert(lines.end(), end.begin(), end.end());
  }
  hdf5::write_dataset<double>(file, "crack_path/section", {position.size()}, position, "m");
  hdf5::write_dataset<std::int32_t>(file, "crack_path/section_axis", {axis.size()}, axis, "");
  const hdf5::Handle dataset = hdf5::open_dataset(file, "crack_path/section_axis");
  hdf5::write_attribute(dataset, "meaning", "axis across the section");
  hdf5::write_attribute(dataset, "categories", lines.empty() ? "1 y, 2 z" : "0 line, 1 y, 2 z");
  if (lines.empty()) return;
  hdf5::write_dataset<double>(file, "crack_path/section_line", {sections.lines.size(), 2, 2}, lines, "m");
  hdf5::write_attribute(hdf5::open_dataset(file, "crack_path/section_line"), "meaning",
                        "y and z of each line's start and end");
}

/// Creates the group /samples/inputs, if there are random inputs, with the values of pending samples.
void lay_out_inputs(hid_t file, const input::Study& study) {
  if (study.random.empty()) return;
  const hdf5::Handle group = hdf5::create_group(file, "samples/inputs");
  write_random_keys(group, study.random);
  const std::vector<double> column(static_cast<std::size_t>(study.ensemble.samples), SampleSummary::none);
  for (const input::RandomInput& random : study.random) {
    hdf5::write_dataset<double>(group, random.key, {column.size()}, column, units_of(random));
    describe_dataset(group, random.key, input::describe(random));
  }
}

void label_dimensions(hid_t file, const input::Study& study) {
  for (const char* name : {"samples", "timing"})
    hdf5::label_datasets(hdf5::open_group(file, name), {"sample"});
  if (!study.random.empty()) hdf5::label_datasets(hdf5::open_group(file, "samples/inputs"), {"sample"});
  const hdf5::Handle paths = hdf5::open_group(file, "crack_path");
  hdf5::label_datasets(paths, {"sample", "notch", "section"});
  const auto label = [&](const char* name, const std::vector<std::string>& names) {
    hdf5::label_dimensions(hdf5::open_dataset(paths, name), names);
  };
  label("section", {"section"});
  label("section_axis", {"section"});
  if (!study.sections.lines.empty()) label("section_line", {"line", "end", "component"});
  const hdf5::Handle section = hdf5::open_dataset(paths, "section");
  analysis::for_each_position_result([&](const ResultInfo& info, auto) {
    hdf5::attach_scale(hdf5::open_dataset(paths, info.name), section, 2);
  });
}

/// The texts of all samples.
struct Texts {
  std::vector<std::string> errors;
  std::vector<std::string> notes;
};

/// The whole file, with all samples pending except for their texts.
std::vector<std::byte> lay_out(const input::Parameters& parameters, const Texts& texts,
                               const analysis::Statistics& statistics, const geometry::MotherPoints& base,
                               int n_ranks) {
  const hdf5::QuietErrors quiet;
  const EnsembleShape shape = shape_of(parameters);
  const SampleSummary pending = analysis::empty_summary(
      static_cast<int>(shape.n_starts), static_cast<int>(shape.n_sections), analysis::SampleStatus::pending);
  hdf5::MemoryFile file;
  write_identity(file, ensemble_kind, ensemble_schema_version, parameters);
  write_specimen(file, *geometry::make_composite_body(parameters));
  for (const char* name : {"samples", "crack_path", "timing"}) hdf5::create_group(file, name);
  int n_columns = 0;
  for_each_column([&](const std::string& name, const ResultInfo& info, auto value) {
    using Value = std::invoke_result_t<decltype(value), const SampleSummary&>;
    const std::vector<Value> column(shape.n_samples, value(pending));
    hdf5::write_dataset<Value>(file, name, {shape.n_samples}, column, info.units);
    describe_result(file, name, info, n_columns++);
  });
  lay_out_inputs(file, parameters);
  if (shape.n_parts > 0) {
    const std::vector<double> table(shape.n_samples * shape.n_parts, SampleSummary::none);
    hdf5::write_dataset<double>(file, fmt::format("samples/{}", analysis::crack_area_in_info.name),
                                {shape.n_samples, shape.n_parts}, table, analysis::crack_area_in_info.units);
  }
  hdf5::write_texts(file, "samples/error", texts.errors);
  hdf5::write_texts(file, "samples/note", texts.notes);
  write_sections(file, parameters.sections);
  for_each_position_table(shape, [&](const std::string& name, const ResultInfo& info, std::size_t n_sections,
                                     auto values) {
    const auto& row = values(pending);
    using Value = typename std::decay_t<decltype(row)>::value_type;
    std::vector<Value> table;
    for (std::size_t i = 0; i < shape.n_samples; ++i) table.insert(table.end(), row.begin(), row.end());
    hdf5::write_dataset<Value>(file, name, {shape.n_samples, shape.n_starts, n_sections}, table, info.units);
    describe_result(file, name, info, n_columns++);
  });
  label_dimensions(file, parameters);
  lay_out_traces(file, parameters, statistics.start_names, shape);
  lay_out_fragments(file, shape);
  if (shape.n_parts > 0)
    describe_parts(hdf5::open_group(file, "samples"),
                   analysis::crack_parts(parameters.materials, parameters.interfaces), n_columns);
  write_statistics(file, statistics, shape);
  if (parameters.mesh.base == input::Base::shared) write_mother_points(file, base);
  write_provenance(file, n_ranks);
  return file.finish();
}

/// The partial file, opened by all ranks; by a single one without MPI. Collective.
hdf5::Handle open_collectively(const parallel::Communicator& world, const std::filesystem::path& file) {
  const hdf5::Handle access = hdf5::unlocked_access();
  if (world.size() > 1)
    hdf5::check(H5Pset_fapl_mpio(access, world.get(), MPI_INFO_NULL), "HDF5 through MPI-IO");
  return hdf5::Handle(H5Fopen(file.c_str(), H5F_ACC_RDWR, access), H5Fclose, file.string());
}

template <class Value>
void write_rows(hid_t file, const std::string& name, std::size_t first, std::size_t n_rows,
                const std::vector<Value>& values) {
  const std::string what = "dataset " + name;
  const hdf5::Handle dataset = hdf5::open_dataset(file, name);
  const hdf5::Handle space(H5Dget_space(dataset), H5Sclose, what);
  std::array<hsize_t, 3> extent{};
  hdf5::check(H5Sget_simple_extent_dims(space, extent.data(), nullptr), what);
  const std::array<hsize_t, 3> start{first, 0, 0};
  const std::array<hsize_t, 3> count{n_rows, extent[1], extent[2]};
  if (values.empty()) {
    hdf5::check(H5Sselect_none(space), what);
  } else {
    hdf5::check(H5Sselect_hyperslab(space, H5S_SELECT_SET, start.data(), nullptr, count.data(), nullptr),
                what);
  }
  const hsize_t n_values = values.size();
  const hdf5::Handle memory(H5Screate_simple(1, &n_values, nullptr), H5Sclose, what);
  hdf5::check(H5Dwrite(dataset, hdf5::memory_type<Value>(), memory, space, H5P_DEFAULT, values.data()), what);
}

void write_block(hid_t file, const EnsembleBlock& block, const EnsembleShape& shape) {
  for_each_column([&](const std::string& name, const ResultInfo&, auto value) {
    std::vector<std::invoke_result_t<decltype(value), const SampleSummary&>> column;
    for (const SampleSummary& row : block.rows) column.push_back(value(row));
    write_rows(file, name, block.first, block.rows.size(), column);
  });
  for (std::size_t k = 0; k < shape.random_keys.size(); ++k) {
    std::vector<double> column;
    for (const SampleSummary& row : block.rows) column.push_back(value_or_none(row.inputs, k));
    write_rows(file, "samples/inputs/" + shape.random_keys[k], block.first, block.rows.size(), column);
  }
  if (shape.n_parts > 0) {
    std::vector<double> table;
    for (const SampleSummary& row : block.rows)
      for (std::size_t k = 0; k < shape.n_parts; ++k) table.push_back(value_or_none(row.crack_area_in, k));
    write_rows(file, fmt::format("samples/{}", analysis::crack_area_in_info.name), block.first,
               block.rows.size(), table);
  }
  if (shape.n_planes > 0)
    analysis::for_each_trace_result([&](const ResultInfo& info, auto member) {
      std::vector<double> table;
      for (const SampleSummary& row : block.rows)
        for (std::size_t k = 0; k < shape.n_planes * shape.n_trace_rows; ++k)
          table.push_back(k < row.traces.size() ? row.traces[k].*member : SampleSummary::none);
      write_rows(file, fmt::format("plane_traces/{}", info.name), block.first, block.rows.size(), table);
    });
  analysis::for_each_fragment_result([&](const ResultInfo& info, auto member) {
    std::vector<double> column;
    for (const SampleSummary& row : block.rows) column.push_back(row.fragments.*member);
    write_rows(file, fmt::format("fragments/{}", info.name), block.first, block.rows.size(), column);
  });
  std::vector<double> heavier;
  for (const SampleSummary& row : block.rows)
    for (std::size_t k = 0; k < analysis::fragment_shares().size(); ++k)
      heavier.push_back(value_or_none(row.fragments.heavier, k));
  write_rows(file, "fragments/heavier", block.first, block.rows.size(), heavier);
  for_each_position_table(shape, [&](const std::string& name, const ResultInfo&, std::size_t, auto values) {
    std::vector<typename std::decay_t<decltype(values(block.rows.front()))>::value_type> table;
    for (const SampleSummary& row : block.rows) {
      const auto& added = values(row);
      table.insert(table.end(), added.begin(), added.end());
    }
    write_rows(file, name, block.first, block.rows.size(), table);
  });
}

/// Maximum allocation by MPI-IO and HDF5 while the ranks wait for each other [byte].
constexpr std::size_t room_for_writing = std::size_t{64} << 20;

/// All ranks write their rows into the file. Collective; a rank that fails still takes part in closing it.
void write_blocks(const parallel::Communicator& world, const std::filesystem::path& file,
                  const EnsembleBlock& block, const EnsembleShape& shape) {
  const hdf5::QuietErrors quiet;
  // Opening is the only step that could leave ranks waiting, so first make sure that every rank can open the
  // file.
  parallel::agree(world, [&] {
    if (::access(file.c_str(), R_OK | W_OK) != 0) fail("rank {}: {}", world.rank(), std::strerror(errno));
    if (world.size() == 1) return;
    // Memory is needed too: MPI-IO loads its libraries when the first file is opened.
    try {
      parallel::check_room(room_for_writing);
      MPI_File alone = MPI_FILE_NULL;
      parallel::check_mpi(MPI_File_open(MPI_COMM_SELF, file.c_str(), MPI_MODE_RDWR, MPI_INFO_NULL, &alone),
                          "MPI_File_open");
      parallel::check_mpi(MPI_File_close(&alone), "MPI_File_close");
    } catch (const std::exception& failure) {
      fail("rank {}: {}", world.rank(), failure.what());
    }
  });
  std::optional<std::string> error;
  const auto attempt = [&error](const auto& step) {
    try {
      step();
    } catch (const std::exception& failure) {
      if (!error) error = failure.what();
    }
  };
  hdf5::Handle shared;
  attempt([&] { shared = open_collectively(world, file); });
  parallel::agree_on_error(world, error);
  attempt([&] { write_block(shared, block, shape); });
  attempt([&] { hdf5::check(H5Fflush(shared, H5F_SCOPE_GLOBAL), "flush"); });
  attempt([&] { shared.close("close"); });
  parallel::agree_on_error(world, error);
}

}  // namespace

void write_ensemble(const parallel::Communicator& world, const std::filesystem::path& file,
                    const input::Parameters& parameters, const EnsembleBlock& block,
                    const analysis::Statistics& statistics, const geometry::MotherPoints& base) {
  const EnsembleShape shape = shape_of(parameters);
  try {
    parallel::agree(world, [&] { check_block(block, shape); });
    check_disjoint(world, block);
    const Texts texts{gather_texts(world, block, &SampleSummary::error, shape.n_samples),
                      gather_texts(world, block, &SampleSummary::note, shape.n_samples)};
    std::optional<PartialFile> partial;  // on the root: removes the file unless it was committed
    parallel::agree(world, [&] {
      if (!world.is_root()) return;
      // A run and a process that recomputes the statistics may write the same file.
      partial.emplace(file, tag_of_this_process());
      partial->write(lay_out(parameters, texts, statistics, base, world.size()));
    });
    const std::string partial_name =
        parallel::share(world, partial ? partial->partial_name().string() : std::string());
    write_blocks(world, partial_name, block, shape);
    parallel::agree(world, [&] {
      if (partial) partial->commit();
    });
  } catch (const parallel::AgreedError& error) {
    throw parallel::AgreedError(error.failing_rank(), cannot_write(file, error.what()));
  }
}

}  // namespace crackle::io
