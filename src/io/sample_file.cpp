// SPDX-License-Identifier: GPL-3.0-or-later
#include "crackle/io/sample_file.h"

#include "checked_file.h"
#include "hdf5.h"
#include "memory_file.h"
#include "provenance.h"
#include "result_attributes.h"
#include "sample_shape.h"
#include "specimen.h"

#include <fmt/format.h>

#include <type_traits>
#include <utility>

namespace crackle::io {

namespace {

using analysis::ResultInfo;
using analysis::SampleSummary;
using hdf5::Shape;
using hdf5::Storage;

/// Writes one column of a table: `value(row)` for every row.
template <class Value, class Row, class Function>
void write_column(hid_t group, const std::string& name, const std::vector<Row>& rows, Function value,
                  const std::string& units) {
  std::vector<Value> column;
  column.reserve(rows.size());
  for (const Row& row : rows) column.push_back(static_cast<Value>(value(row)));
  hdf5::write_dataset<Value>(group, name, {column.size()}, column, units, Storage::compressed);
}

/// Entries of fixed-size arrays one after the other.
template <class Value, class Row, class Member>
std::vector<Value> flatten(const std::vector<Row>& rows, Member array_of) {
  std::vector<Value> flat;
  for (const Row& row : rows) {
    for (const auto& value : array_of(row)) flat.push_back(value);
  }
  return flat;
}

void write_mesh(hid_t file, const geometry::Realization& realization) {
  const hdf5::Handle group = hdf5::create_group(file, "mesh");
  const auto itself = [](const auto& row) -> const auto& {
    return row;
  };
  hdf5::write_dataset<double>(group.get(), "nodes", {realization.nodes.size(), 3},
                              flatten<double>(realization.nodes, itself), "m", Storage::compressed);
  hdf5::write_dataset<std::int32_t>(group.get(), "tetrahedra", {realization.tetrahedra.size(), 4},
                                    flatten<std::int32_t>(realization.tetrahedra, itself), "",
                                    Storage::compressed);
  hdf5::write_dataset<std::int32_t>(
      group.get(), "boundary", {realization.boundary.size(), 3},
      flatten<std::int32_t>(realization.boundary, [](const auto& row) { return row.nodes; }), "",
      Storage::compressed);
  write_column<std::int32_t>(
      group.get(), "boundary_surface", realization.boundary, [](const auto& row) { return row.surface; }, "");
  hdf5::write_attribute(group.get(), "rounds", std::int64_t{realization.report.rounds});
  hdf5::write_attribute(group.get(), "attempt", std::int64_t{realization.report.attempt});
  hdf5::write_attribute(group.get(), "redrawn_points", realization.report.redrawn_points);
  hdf5::write_attribute(group.get(), "reflected_axes", std::int64_t{realization.report.symmetry});
  hdf5::write_attribute(group.get(), "min_quality", realization.report.min_quality);
}

void write_crack_surface(hid_t file, const analysis::CrackSurface& surface,
                         const std::vector<std::int32_t>& arm) {
  using analysis::Crack;
  using analysis::CrackFacet;
  const hdf5::Handle group = hdf5::create_group(file, "crack_surface");
  const auto& facets = surface.facets;
  std::vector<double> corners;
  corners.reserve(facets.size() * 12);
  for (const CrackFacet& facet : facets) {
    for (const geometry::Point& corner : facet.corner) {
      corners.insert(corners.end(), corner.begin(), corner.end());
    }
  }
  hdf5::write_dataset<double>(group.get(), "corners", {facets.size(), 4, 3}, corners, "m",
                              Storage::compressed);
  const hid_t id = group.get();
  write_column<double>(
      id, "time", facets, [](const CrackFacet& f) { return f.time; }, "s");
  write_column<double>(
      id, "area", facets, [](const CrackFacet& f) { return f.area; }, "m^2");
  write_column<std::int64_t>(
      id, "tetrahedron", facets, [](const CrackFacet& f) { return f.tetrahedron; }, "");
  write_column<std::int32_t>(
      id, "crack", facets, [](const CrackFacet& f) { return f.crack; }, "");
  hdf5::write_dataset<std::int32_t>(id, "arm", {arm.size()}, arm, "", Storage::compressed);

  const hdf5::Handle table = hdf5::create_group(id, "cracks");
  write_column<std::int32_t>(
      table.get(), "notch", surface.cracks, [](const Crack& c) { return c.notch; }, "");
  write_column<double>(
      table.get(), "area", surface.cracks, [](const Crack& c) { return c.area; }, "m^2");
  write_column<double>(
      table.get(), "first_time", surface.cracks, [](const Crack& c) { return c.first_time; }, "s");
  write_column<double>(
      table.get(), "last_time", surface.cracks, [](const Crack& c) { return c.last_time; }, "s");
}

template <class Value, class Row, class Function>
void write_described_column(hid_t group, const char* name, const std::vector<Row>& rows, Function value,
                            const std::string& units, const std::string& meaning) {
  write_column<Value>(group, name, rows, value, units);
  describe_dataset(group, name, meaning);
}

void write_forks(hid_t file, const std::vector<analysis::Fork>& forks) {
  using analysis::Fork;
  const hdf5::Handle group = hdf5::create_group(file, "forks");
  const hid_t id = group.get();
  std::vector<double> position;
  for (const Fork& fork : forks) position.insert(position.end(), {fork.y, fork.z});
  hdf5::write_dataset<double>(id, "position", {forks.size(), 2}, position, "m", Storage::compressed);
  describe_dataset(id, "position", "y, z where the gap between the arms begins");
  write_described_column<double>(
      id, "x", forks, [](const Fork& f) { return f.x; }, "m",
      "middle of the range that the arm which leaves spans through the thickness");
  write_described_column<double>(
      id, "time", forks, [](const Fork& f) { return f.time; }, "s",
      "when the later arm opened, since the onset of the last dynamic phase");
  write_described_column<double>(
      id, "length", forks, [](const Fork& f) { return f.length; }, "m",
      "of the arm that leaves, from the fork straight to its end");
  write_described_column<double>(
      id, "angle", forks, [](const Fork& f) { return f.angle; }, "rad", "between the arms where they part");
  write_described_column<double>(
      id, "share", forks, [](const Fork& f) { return f.share; }, "1",
      "of the thickness: the range that the arm which leaves spans");
  write_described_column<std::int32_t>(
      id, "notch", forks, [](const Fork& f) { return f.notch; }, "", "that the crack started at");
  write_described_column<std::uint8_t>(
      id, "in_projection", forks, [](const Fork& f) { return f.is_in_projection; }, "",
      "1 where the crack projected on the plane of the plate shows it");
  write_described_column<std::uint8_t>(
      id, "in_space", forks, [](const Fork& f) { return f.is_in_space; }, "",
      "1 where a window through the thickness shows it");
}

/// Rows are the separate crossings of each notch and section.
void write_crossings(hid_t file, const std::vector<analysis::SectionCrossing>& crossings,
                     std::size_t n_sections) {
  struct Row {
    std::size_t notch, section;
    analysis::ArmCrossing crossing;
  };
  std::vector<Row> rows;
  for (std::size_t i = 0; i < crossings.size(); ++i)
    for (const analysis::ArmCrossing& arm : crossings[i].arms)
      rows.push_back({i / n_sections, i % n_sections, arm});
  const hdf5::Handle group = hdf5::create_group(file, "crossings");
  const hid_t id = group.get();
  write_described_column<double>(
      id, "position", rows, [](const Row& r) { return r.crossing.position; }, "m",
      "coordinate along the section, through-thickness mean");
  write_described_column<double>(
      id, "share", rows, [](const Row& r) { return r.crossing.share; }, "1",
      "of the thickness that it covers");
  write_described_column<std::int32_t>(
      id, "arm", rows, [](const Row& r) { return r.crossing.arm; }, "",
      "0 for the main arm, i + 1 for the one that leaves at fork i");
  write_described_column<std::int32_t>(
      id, "notch", rows, [](const Row& r) { return r.notch; }, "", "that the crack started at");
  write_described_column<std::int32_t>(
      id, "section", rows, [](const Row& r) { return r.section; }, "", "number of the section");
}

void write_crack_lines(hid_t file, const std::vector<analysis::CrackLine>& lines) {
  using analysis::CrackLine;
  using analysis::LinePoint;
  const hdf5::Handle group = hdf5::create_group(file, "crack_lines");
  const hid_t id = group.get();
  std::vector<std::int64_t> first;
  std::vector<LinePoint> points;
  std::vector<double> position;
  for (const CrackLine& line : lines) {
    first.push_back(static_cast<std::int64_t>(points.size()));
    points.insert(points.end(), line.points.begin(), line.points.end());
  }
  for (const LinePoint& p : points) position.insert(position.end(), {p.y, p.z});
  hdf5::write_dataset<double>(id, "position", {points.size(), 2}, position, "m", Storage::compressed);
  write_column<double>(
      id, "spread", points, [](const LinePoint& p) { return p.spread; }, "m");
  write_column<double>(
      id, "time", points, [](const LinePoint& p) { return p.time; }, "s");

  const hdf5::Handle table = hdf5::create_group(id, "lines");
  hdf5::write_dataset<std::int64_t>(table.get(), "first", {first.size()}, first, "");
  write_column<std::int64_t>(
      table.get(), "count", lines, [](const CrackLine& l) { return l.points.size(); }, "");
  write_column<std::int32_t>(
      table.get(), "notch", lines, [](const CrackLine& l) { return l.notch; }, "");
  write_column<std::int32_t>(
      table.get(), "parent", lines, [](const CrackLine& l) { return l.parent; }, "");
  write_column<std::int32_t>(
      table.get(), "kinks", lines, [](const CrackLine& l) { return l.kinks; }, "");
  write_column<double>(
      table.get(), "bend", lines, [](const CrackLine& l) { return l.bend; }, "rad");
}

void write_breaks(hid_t file, const std::vector<fracture::Break>& breaks) {
  using fracture::Break;
  const hdf5::Handle group = hdf5::create_group(file, "breaks");
  const hid_t id = group.get();
  write_column<std::int64_t>(
      id, "tetrahedron", breaks, [](const Break& b) { return b.tetrahedron; }, "");
  write_column<double>(
      id, "load_time", breaks, [](const Break& b) { return b.load_time; }, "s");
  write_column<double>(
      id, "phase_time", breaks, [](const Break& b) { return b.phase_time; }, "s");
  write_column<double>(
      id, "principal_stress", breaks, [](const Break& b) { return b.principal_stress; }, "Pa");
  write_column<double>(
      id, "released_energy", breaks, [](const Break& b) { return b.released_energy; }, "J");
  write_column<std::int32_t>(
      id, "cut", breaks, [](const Break& b) { return b.cut; }, "");
}

void write_ties(hid_t file, const std::vector<fracture::Tie>& ties) {
  using fracture::Tie;
  const hdf5::Handle group = hdf5::create_group(file, "ties");
  const hid_t id = group.get();
  write_column<std::int64_t>(
      id, "tetrahedron", ties, [](const Tie& t) { return t.tetrahedron; }, "");
  write_column<double>(
      id, "load_time", ties, [](const Tie& t) { return t.load_time; }, "s");
  write_column<double>(
      id, "phase_time", ties, [](const Tie& t) { return t.phase_time; }, "s");
  write_column<double>(
      id, "released_energy", ties, [](const Tie& t) { return t.released_energy; }, "J");
  write_column<std::uint8_t>(
      id, "edges", ties, [](const Tie& t) { return t.edges; }, "");
}

void write_energy(hid_t file, const std::vector<dynamics::EnergyRow>& rows) {
  using dynamics::EnergyRow;
  const hdf5::Handle group = hdf5::create_group(file, "energy");
  const hid_t id = group.get();
  write_column<double>(
      id, "time", rows, [](const EnergyRow& r) { return r.time; }, "s");
  write_column<double>(
      id, "kinetic", rows, [](const EnergyRow& r) { return r.kinetic; }, "J");
  write_column<double>(
      id, "strain", rows, [](const EnergyRow& r) { return r.strain; }, "J");
  write_column<double>(
      id, "external", rows, [](const EnergyRow& r) { return r.external; }, "J");
  write_column<double>(
      id, "released", rows, [](const EnergyRow& r) { return r.released; }, "J");
  write_column<double>(
      id, "dissipated", rows, [](const EnergyRow& r) { return r.dissipated; }, "J");
  write_column<std::int64_t>(
      id, "broken", rows, [](const EnergyRow& r) { return r.broken; }, "");
}

void write_frames(hid_t file, const std::vector<dynamics::Frame>& frames, std::size_t n_nodes,
                  const input::Material& material) {
  using dynamics::Frame;
  const hdf5::Handle group = hdf5::create_group(file, "frames");
  const hid_t id = group.get();
  // With these, whoever has the displacement has the stress.
  hdf5::write_attribute(id, "youngs_modulus", material.youngs_modulus);
  hdf5::write_attribute(id, "poisson_ratio", material.poisson_ratio);
  const Shape shape{frames.size(), n_nodes, 3};
  write_column<double>(
      id, "time", frames, [](const Frame& f) { return f.time; }, "s");
  write_column<std::int64_t>(
      id, "broken", frames, [](const Frame& f) { return f.broken; }, "");
  hdf5::write_dataset<float>(id, "displacement", shape,
                             flatten<float>(
                                 frames, [](const Frame& f) -> auto& { return f.displacement; }),
                             "m", Storage::compressed);
  hdf5::write_dataset<float>(id, "velocity", shape,
                             flatten<float>(
                                 frames, [](const Frame& f) -> auto& { return f.velocity; }),
                             "m/s", Storage::compressed);
}

void write_counts(hid_t file, const dynamics::SampleCounts& counts) {
  const hdf5::Handle group = hdf5::create_group(file, "counts");
  const hid_t id = group.get();
  hdf5::write_scalar<std::int64_t>(id, "quasi_static_breaks", counts.quasi_static_breaks, "");
  hdf5::write_scalar<std::int64_t>(id, "static_solves", counts.static_solves, "");
  hdf5::write_scalar<std::int64_t>(id, "solver_iterations", counts.solver_iterations, "");
  hdf5::write_scalar<std::int64_t>(id, "dynamic_phases", counts.dynamic_phases, "");
  hdf5::write_scalar<std::int64_t>(id, "steps", counts.steps, "");
  hdf5::write_scalar<std::int64_t>(id, "force_evaluations", counts.force_evaluations, "");
  hdf5::write_scalar<std::int64_t>(id, "range_restarts", counts.range_restarts, "");
}

/// Identity, status and the sample's row. @return the group /summary
hdf5::Handle write_row(hid_t file, const input::Parameters& parameters, std::uint64_t sample,
                       const SampleSummary& summary) {
  write_identity(file, sample_kind, sample_schema_version, parameters);
  hdf5::write_attribute(file, "sample", sample);
  hdf5::write_attribute(file, "status", static_cast<std::int64_t>(summary.status));
  hdf5::write_attribute(file, "status_categories", std::string(analysis::status_categories));
  hdf5::write_attribute(file, "error", summary.error);
  hdf5::write_attribute(file, "note", summary.note);
  hdf5::Handle group = hdf5::create_group(file, "summary");
  const hid_t id = group.get();
  int n_columns = 1;  // behind the status
  analysis::for_each_result([&](const ResultInfo& info, auto member) {
    hdf5::write_scalar(id, info.name, summary.*member, info.units);
    describe_result(id, info.name, info, n_columns++);
  });
  analysis::for_each_position_result([&](const ResultInfo& info, auto member) {
    using Value = typename std::remove_cvref_t<decltype(summary.*member)>::value_type;
    hdf5::write_dataset<Value>(id, info.name, position_shape(parameters), summary.*member, info.units);
    describe_result(id, info.name, info, n_columns++);
  });
  return group;
}

hdf5::Handle write_timing(hid_t file, const SampleSummary& summary) {
  hdf5::Handle group = hdf5::create_group(file, "timing");
  hdf5::write_scalar<double>(group.get(), "wall_time", summary.wall_time, "s");
  return group;
}

/// Fills a file in memory and writes it; failures name the file.
template <class Fill>
void write_file(const std::filesystem::path& path, Fill fill) {
  std::vector<std::byte> bytes;
  try {
    const hdf5::QuietErrors quiet;
    hdf5::MemoryFile file;
    fill(file.get());
    bytes = file.finish();
  } catch (const std::exception& error) {
    throw std::runtime_error("cannot write '" + path.string() + "': " + error.what());
  }
  write_checked_file(path, std::move(bytes));
}

}  // namespace

std::filesystem::path sample_path(const std::filesystem::path& folder, std::uint64_t sample) {
  return folder / "samples" / fmt::format("{:04}.h5", sample);
}

void write_sample(const std::filesystem::path& file, const SampleFileContent& content) {
  write_file(file, [&](hid_t id) {
    const dynamics::SampleResult& result = content.result;
    const hdf5::Handle summary = write_row(id, content.parameters, content.sample, content.summary);
    hdf5::write_scalar<double>(summary.get(), "phase_start", result.phase_start, "s");
    hdf5::write_scalar<double>(summary.get(), "time_step", result.time_step, "s");
    hdf5::write_scalar<double>(summary.get(), "stable_step", result.stable_step, "s");
    write_specimen(id, *geometry::make_body(content.parameters.specimen));
    write_mesh(id, content.realization);
    write_crack_surface(id, content.surface, content.arms.arm);
    write_crack_lines(id, content.lines);
    write_forks(id, content.arms.forks);
    write_crossings(id, content.crossings, content.parameters.sections.size());
    write_breaks(id, result.breaks);
    if (content.parameters.fracture.release == input::Release::facet) write_ties(id, result.ties);
    write_energy(id, result.energy);
    write_frames(id, result.frames, content.realization.nodes.size(), content.parameters.material);
    write_counts(id, result.counts);
    const hdf5::Handle timing = write_timing(id, content.summary);
    hdf5::write_scalar<double>(timing.get(), "mesh", result.timings.mesh, "s");
    hdf5::write_scalar<double>(timing.get(), "setup", result.timings.setup, "s");
    hdf5::write_scalar<double>(timing.get(), "quasi_static", result.timings.quasi_static, "s");
    hdf5::write_scalar<double>(timing.get(), "dynamic", result.timings.dynamic, "s");
    hdf5::write_scalar<double>(timing.get(), "ghost_seconds", result.timings.traffic.seconds, "s");
    hdf5::write_scalar<std::int64_t>(timing.get(), "ghost_exchanges", result.timings.traffic.n_exchanges,
                                     "1");
    hdf5::write_scalar<std::int64_t>(timing.get(), "ghost_bytes_per_exchange",
                                     result.timings.traffic.bytes_per_exchange, "byte");
    hdf5::write_scalar<double>(timing.get(), "element_updates_per_second",
                               result.timings.element_updates_per_second, "1/s");
    write_provenance(id, content.n_ranks);
  });
}

void write_failed_sample(const std::filesystem::path& file, const input::Parameters& parameters,
                         std::uint64_t sample, const SampleSummary& summary) {
  write_file(file, [&](hid_t id) {
    write_row(id, parameters, sample, summary);
    write_timing(id, summary);
    write_provenance(id, 1);
  });
}

}  // namespace crackle::io
