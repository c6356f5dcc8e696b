// SPDX-License-Identifier: GPL-3.0-or-later
#include "io/sample_file.h"

#include "common/checksum.h"
#include "common/index.h"
#include "cracks/plane_traces.h"
#include "fracture/initial_strain.h"
#include "fracture/material_field.h"
#include "fracture/release_time.h"
#include "geometry/flaws.h"
#include "geometry/pre_crack.h"
#include "input/reader.h"

#include "hdf5.h"
#include "partial_file.h"
#include "provenance.h"
#include "result_attributes.h"
#include "sample_groups.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <functional>
#include <type_traits>
#include <utility>

namespace crackle::io {

namespace {

using analysis::ResultInfo;
using analysis::SampleSummary;
using hdf5::Shape;
using hdf5::Storage;

void write_mesh(hid_t file, const geometry::Realization& realization) {
  using geometry::BoundaryTriangle;
  const hdf5::Handle group = hdf5::create_group(file, "mesh");
  write_column<double>(group, "nodes", realization.nodes, std::identity(), "m");
  write_column<std::int32_t>(group, "tetrahedra", realization.tetrahedra, std::identity());
  write_column<std::int32_t>(group, "boundary", realization.boundary, &BoundaryTriangle::nodes);
  write_column<std::int32_t>(group, "boundary_surface", realization.boundary, &BoundaryTriangle::surface);
  hdf5::write_attribute(group, "rounds", std::int64_t{realization.report.rounds});
  hdf5::write_attribute(group, "attempt", std::int64_t{realization.report.attempt});
  hdf5::write_attribute(group, "redrawn_points", realization.report.redrawn_points);
  hdf5::write_attribute(group, "symmetry", std::int64_t{realization.report.symmetry});
  hdf5::write_attribute(group, "min_quality", realization.report.min_quality);
}

/// The box around each crack.
void write_extents(hid_t cracks, const cracks::CrackSurface& surface) {
  std::vector<geometry::Box> boxes(surface.cracks.size(), geometry::nowhere);
  for (const cracks::CrackFacet& facet : surface.facets)
    for (const geometry::Point& corner : facet.corner) boxes[index(facet.crack)].include(corner);
  write_column<double>(cracks, "lower", boxes, &geometry::Box::lower, "m", "least x, y, z of the crack");
  write_column<double>(cracks, "upper", boxes, &geometry::Box::upper, "m", "greatest x, y, z of the crack");
}

/// @param is_solid the body is not a plate
void write_crack_surface(hid_t file, const cracks::CrackSurface& surface,
                         const std::vector<std::int32_t>& branch, bool is_solid) {
  using cracks::Crack;
  using cracks::CrackFacet;
  const hdf5::Handle group = hdf5::create_group(file, "crack_surface");
  write_column<double>(group, "corners", surface.facets, &CrackFacet::corner, "m");
  write_column<double>(group, "time", surface.facets, &CrackFacet::time, "s");
  write_column<double>(group, "area", surface.facets, &CrackFacet::area, "m^2");
  write_column<std::int64_t>(group, "tetrahedron", surface.facets, &CrackFacet::tetrahedron);
  write_column<std::int32_t>(group, "crack", surface.facets, &CrackFacet::crack);
  if (!is_solid) write_column<std::int32_t>(group, "branch", branch, std::identity());
  hdf5::label_datasets(group, {"facet", "corner", "component"});

  const hdf5::Handle table = hdf5::create_group(group, "cracks");
  write_column<std::int32_t>(table, "notch", surface.cracks, &Crack::start);
  write_column<std::int32_t>(table, "hole", surface.cracks, &Crack::hole, "",
                             "that the crack leaves, continuing one that ran into it; -1 for others");
  write_column<double>(table, "area", surface.cracks, &Crack::area, "m^2");
  write_column<double>(table, "first_time", surface.cracks, &Crack::first_time, "s");
  write_column<double>(table, "last_time", surface.cracks, &Crack::last_time, "s");
  if (is_solid) write_extents(table, surface);
  hdf5::label_datasets(table, {"crack", "component"});
}

/// @param is_solid the body is not a plate
void write_branching(hid_t file, const std::vector<cracks::BranchingPoint>& points, bool is_solid) {
  using cracks::BranchingPoint;
  const hdf5::Handle group = hdf5::create_group(file, "forks");
  const auto place = [](const BranchingPoint& point) { return std::array{point.y, point.z}; };
  write_column<double>(group, "position", points, place, "m",
                       is_solid ? "y, z of the line in which the sheets meet, its mean"
                                : "y, z where the gap between the branches begins");
  write_column<double>(
      group, "x", points, &BranchingPoint::x, "m",
      is_solid ? "likewise" : "middle of the range that the secondary branch spans through the thickness");
  write_column<double>(group, "time", points, &BranchingPoint::time, "s",
                       "when the later branch opened, since the onset of the last dynamic phase");
  write_column<double>(group, "length", points, &BranchingPoint::length, "m",
                       "of the secondary branch, from the branching point straight to its end");
  write_column<double>(group, "angle", points, &BranchingPoint::angle, "rad",
                       "between the branches where they separate");
  write_column<double>(group, "share", points, &BranchingPoint::share, "1",
                       "of the thickness: the range that the secondary branch spans; NaN in a solid");
  write_column<std::int32_t>(group, "notch", points, &BranchingPoint::start, "", "that the crack started at");
  write_column<std::uint8_t>(group, "in_projection", points, &BranchingPoint::is_in_projection, "",
                             "1 where the crack projected on the plane of the plate shows it");
  write_column<std::uint8_t>(group, "in_space", points, &BranchingPoint::is_in_space, "",
                             "1 where space, in plates a window through the thickness, shows it");
  hdf5::label_datasets(group, {"branching point", "component"});
}

/// Rows are the separate crossings of each notch and section.
void write_crossings(hid_t file, const std::vector<cracks::SectionCrossing>& crossings,
                     std::size_t n_sections) {
  struct Row : cracks::BranchCrossing {
    std::size_t start, section;
  };
  std::vector<Row> rows;
  for (std::size_t i = 0; i < crossings.size(); ++i)
    for (const cracks::BranchCrossing& crossing : crossings[i].branches)
      rows.push_back({crossing, i / n_sections, i % n_sections});
  const hdf5::Handle group = hdf5::create_group(file, "crossings");
  write_column<double>(group, "position", rows, &Row::position, "m",
                       "coordinate along the section, through-thickness mean");
  write_column<double>(group, "share", rows, &Row::share, "1", "of the thickness that it covers");
  write_column<std::int32_t>(group, "branch", rows, &Row::branch, "",
                             "0 for the main branch, i + 1 for the secondary one of branching point i");
  write_column<std::int32_t>(group, "notch", rows, &Row::start, "", "that the crack started at");
  write_column<std::int32_t>(group, "section", rows, &Row::section, "", "number of the section");
  hdf5::label_datasets(group, {"crossing"});
}

void write_plane_traces(hid_t file, const cracks::CrackSurface& surface,
                        const std::vector<input::SectionPlane>& planes) {
  using cracks::PlaneTrace;
  if (planes.empty()) return;
  const std::vector<PlaneTrace> traces = cracks::plane_traces(surface, planes);
  const hdf5::Handle group = hdf5::create_group(file, "plane_traces");
  write_column<std::int32_t>(group, "plane", traces, &PlaneTrace::plane, "", "number of the plane");
  write_column<std::int32_t>(group, "crack", traces, &PlaneTrace::crack, "", "row of /crack_surface/cracks");
  write_column<std::int32_t>(
      group, "notch", traces,
      [&](const PlaneTrace& trace) { return surface.cracks[index(trace.crack)].start; }, "",
      "that the crack started at");
  write_column<double>(group, "length", traces, &PlaneTrace::length, "m", "of the trace, along all facets");
  write_column<double>(group, "position", traces, &PlaneTrace::position, "m", "x, y, z: mean of the trace");
  write_column<double>(group, "time", traces, &PlaneTrace::first_time, "s",
                       "when the crack came to the plane");
  hdf5::label_datasets(group, {"trace", "component"});
}

void write_crack_lines(hid_t file, const std::vector<cracks::CrackLine>& lines) {
  using cracks::CrackLine;
  using cracks::LinePoint;
  const hdf5::Handle group = hdf5::create_group(file, "crack_lines");
  std::vector<std::int64_t> first;
  std::vector<LinePoint> points;
  for (const CrackLine& line : lines) {
    first.push_back(static_cast<std::int64_t>(points.size()));
    points.insert(points.end(), line.points.begin(), line.points.end());
  }
  const auto place = [](const LinePoint& point) { return std::array{point.y, point.z}; };
  write_column<double>(group, "position", points, place, "m");
  write_column<double>(group, "spread", points, &LinePoint::spread, "m");
  write_column<double>(group, "time", points, &LinePoint::time, "s");
  hdf5::label_datasets(group, {"point", "component"});

  const hdf5::Handle table = hdf5::create_group(group, "lines");
  hdf5::write_dataset<std::int64_t>(table, "first", {first.size()}, first, "");
  write_column<std::int64_t>(table, "count", lines, [](const CrackLine& l) { return l.points.size(); });
  write_column<std::int32_t>(table, "notch", lines, &CrackLine::start);
  write_column<std::int32_t>(table, "parent", lines, &CrackLine::parent);
  write_column<std::int32_t>(table, "kinks", lines, &CrackLine::kinks);
  write_column<double>(table, "bend", lines, &CrackLine::bend, "rad");
  hdf5::label_datasets(table, {"line"});
}

/// Writes the tetrahedra and times of releases: the first columns of every kind of release.
template <class Release>
void write_moments(hid_t group, const std::vector<Release>& releases) {
  write_column<std::int64_t>(group, "tetrahedron", releases, &Release::tetrahedron);
  write_column<double>(group, "load_time", releases, &Release::load_time, "s");
  write_column<double>(group, "phase_time", releases, &Release::phase_time, "s");
}

void write_breaks(hid_t file, const std::vector<fracture::Break>& breaks) {
  using fracture::Break;
  const hdf5::Handle group = hdf5::create_group(file, "breaks");
  write_moments(group, breaks);
  write_column<double>(group, "principal_stress", breaks, &Break::principal_stress, "Pa");
  write_column<double>(group, "released_energy", breaks, &Break::released_energy, "J");
  write_column<std::int32_t>(group, "cut", breaks, &Break::cut);
  hdf5::label_datasets(group, {"break"});
}

void write_bridge_releases(hid_t file, const std::vector<fracture::BridgeRelease>& bridge_releases) {
  using fracture::BridgeRelease;
  const hdf5::Handle group = hdf5::create_group(file, "bridge_releases");
  write_moments(group, bridge_releases);
  write_column<double>(group, "released_energy", bridge_releases, &BridgeRelease::released_energy, "J");
  write_column<std::uint8_t>(group, "edges", bridge_releases, &BridgeRelease::edges);
}

void write_stiffness_reductions(hid_t file,
                                const std::vector<fracture::StiffnessReduction>& stiffness_reductions) {
  using fracture::StiffnessReduction;
  const hdf5::Handle group = hdf5::create_group(file, "softening");
  write_moments(group, stiffness_reductions);
  write_column<double>(group, "released_energy", stiffness_reductions, &StiffnessReduction::released_energy,
                       "J");
  write_column<double>(group, "share", stiffness_reductions, &StiffnessReduction::share);
}

void write_energy(hid_t file, const std::vector<dynamics::EnergyRow>& rows) {
  using dynamics::EnergyRow;
  const hdf5::Handle group = hdf5::create_group(file, "energy");
  write_column<double>(group, "time", rows, &EnergyRow::time, "s");
  write_column<double>(group, "kinetic", rows, &EnergyRow::kinetic, "J");
  write_column<double>(group, "strain", rows, &EnergyRow::strain, "J");
  write_column<double>(group, "external", rows, &EnergyRow::external, "J");
  write_column<double>(group, "released", rows, &EnergyRow::released, "J");
  write_column<double>(group, "dissipated", rows, &EnergyRow::dissipated, "J");
  write_column<std::int64_t>(group, "broken", rows, &EnergyRow::broken);
  hdf5::label_datasets(group, {"moment"}, "time");
}

/// The tetrahedra of a realization.
fracture::TetrahedronSpan all_of(const geometry::Realization& mesh) {
  return {mesh.nodes, mesh.tetrahedra, {}, mesh.material, mesh.map_factor};
}

void write_frames(hid_t file, const std::vector<dynamics::Frame>& frames, const geometry::Realization& mesh,
                  const input::Model& model) {
  using dynamics::Frame;
  const std::size_t n_nodes = mesh.nodes.size();
  const hdf5::Handle group = hdf5::create_group(file, "frames");
  // Needed to compute the stress from the displacement.
  hdf5::write_attribute(group, "youngs_modulus", model.material().youngs_modulus);
  hdf5::write_attribute(group, "poisson_ratio", model.material().poisson_ratio);
  const auto release_time = fracture::release_times(model, all_of(mesh));
  hdf5::write_attribute(group, "release_time", release_time.is_uniform() ? release_time[0] : 0);
  if (!release_time.is_uniform())
    write_column<double>(file, "mesh/release_time", release_time.values(), std::identity(), "s",
                         "over which the stiffness of each tetrahedron falls");
  write_column<double>(group, "time", frames, &Frame::time, "s");
  write_column<std::int64_t>(group, "broken", frames, &Frame::broken);
  const auto write_field = [&](const char* name, std::vector<float> Frame::*field, const char* units) {
    std::vector<float> values;
    for (const Frame& frame : frames) hdf5::flatten(frame.*field, values);
    hdf5::write_dataset<float>(group, name, {frames.size(), n_nodes, 3}, values, units, Storage::compressed);
  };
  write_field("displacement", &Frame::displacement, "m");
  write_field("velocity", &Frame::velocity, "m/s");
  hdf5::label_datasets(group, {"frame", "node", "component"}, "time");
}

void write_fragments(hid_t file, const dynamics::Fragments& found,
                     const std::vector<dynamics::FragmentCount>& history) {
  using dynamics::Fragment;
  if (found.of_node.empty()) return;
  const hdf5::Handle group = hdf5::create_group(file, "fragments");
  const auto& pieces = found.pieces;
  write_column<double>(group, "mass", pieces, &Fragment::mass, "kg", "mass of each fragment");
  write_column<double>(
      group, "share", pieces, [&](const Fragment& one) { return one.mass / found.mass; }, "1",
      "its share of the body's mass");
  write_column<double>(group, "volume", pieces, &Fragment::volume, "m^3", "volume");
  write_column<std::int64_t>(group, "nodes", pieces, &Fragment::n_nodes, "", "number of nodes");
  write_column<std::int64_t>(group, "first_node", pieces, &Fragment::first_node, "", "smallest node number");
  write_column<double>(group, "center", pieces, &Fragment::center, "m",
                       "x, y, z: centre of mass at the end, moved with the fragment");
  write_column<double>(group, "velocity", pieces, &Fragment::velocity, "m/s",
                       "x, y, z: mean velocity, weighted with the mass");
  write_column<double>(group, "kinetic", pieces, &Fragment::kinetic, "J", "kinetic energy");
  write_column<double>(group, "kinetic_of_mean", pieces, &Fragment::kinetic_of_mean, "J",
                       "that of the mean motion; the rest is rotation and vibration");
  write_column<double>(group, "extent", pieces, &Fragment::extent, "m",
                       "along x, y, z in the body before it was loaded");
  write_column<std::uint8_t>(group, "frozen", pieces, &Fragment::is_frozen, "",
                             "1 where it stands still since its numbers would have left their range");
  hdf5::label_datasets(group, {"fragment", "component"});
  write_column<std::int32_t>(group, "of_node", found.of_node, std::identity(), "",
                             "fragment of each node: row of this table; -1: dust");
  hdf5::label_dimensions(hdf5::open_dataset(group, "of_node"), std::vector<std::string>{"node"});

  const hdf5::Handle dust = hdf5::create_group(group, "dust");
  hdf5::write_scalar<std::int64_t>(dust, "nodes", found.dust.n_nodes, "");
  hdf5::write_scalar<double>(dust, "mass", found.dust.mass, "kg");
  hdf5::write_scalar<double>(dust, "volume", found.dust.volume, "m^3");
  hdf5::write_scalar<double>(dust, "kinetic", found.dust.kinetic, "J");
  describe_dataset(dust, "nodes", "number of nodes that nothing holds; they are in no row of the table");

  using dynamics::FragmentCount;
  const hdf5::Handle counts = hdf5::create_group(group, "history");
  write_column<double>(counts, "time", history, &FragmentCount::time, "s",
                       "since the start of the last dynamic phase");
  write_column<std::int64_t>(counts, "number", history, &FragmentCount::number, "",
                             "fragments, without dust");
  write_column<double>(counts, "largest_mass", history, &FragmentCount::largest_mass, "kg",
                       "mass of the largest");
  write_column<double>(counts, "second_mass", history, &FragmentCount::second_mass, "kg",
                       "mass of the second largest; 0 if there is none");
  write_column<std::int64_t>(counts, "dust", history, &FragmentCount::dust, "", "nodes that nothing holds");
  write_column<double>(counts, "dust_mass", history, &FragmentCount::dust_mass, "kg", "their mass");
  write_column<std::int64_t>(counts, "frozen", history, &FragmentCount::frozen, "",
                             "fragments and single nodes frozen so far");
  write_column<double>(counts, "frozen_mass", history, &FragmentCount::frozen_mass, "kg", "their mass");
  write_column<double>(counts, "frozen_energy", history, &FragmentCount::frozen_energy, "J",
                       "kinetic energy taken from them; in /energy it counts as dissipated");
  hdf5::label_datasets(counts, {"moment"}, "time");
}

void write_pre_cracks(hid_t file, const std::vector<std::int32_t>& codes,
                      const std::vector<plane::PreCrack>& flaws) {
  if (codes.empty()) return;
  std::vector<std::int64_t> opened;
  for (std::size_t t = 0; t < codes.size(); ++t)
    if (codes[t] != 0) opened.push_back(static_cast<std::int64_t>(t));
  const auto cut = [&](std::int64_t t) { return geometry::PreCrackCut::from(codes[index(t)]); };
  const hdf5::Handle group = hdf5::create_group(file, "pre_cracks");
  write_column<std::int64_t>(group, "tetrahedron", opened, std::identity(), "",
                             "that is open from the start");
  write_column<std::int32_t>(
      group, "cut", opened, [&](auto t) { return cut(t).cut; }, "", "of its seven, as in /breaks");
  write_column<std::int32_t>(
      group, "crack", opened, [&](auto t) { return cut(t).crack; }, "",
      "number of the pre-crack; those of the input are followed by the flaws");
  if (flaws.empty()) return;
  const hdf5::Handle drawn = hdf5::create_group(group, "flaws");
  write_column<double>(drawn, "center", flaws, &plane::PreCrack::center, "m", "x, y, z");
  write_column<double>(drawn, "normal", flaws, &plane::PreCrack::normal, "1", "of any length");
  write_column<double>(
      drawn, "radius", flaws, [](const plane::PreCrack& flaw) { return flaw.semi_axes[0]; }, "m", "radius");
}

/// Properties of the tetrahedra, as far as they differ.
void write_materials(hid_t file, const SampleFileContent& content) {
  const geometry::Realization& mesh = content.realization;
  const input::Model& model = content.parameters;
  const fracture::TetrahedronSpan all = all_of(mesh);
  // Values that are those of the attributes of /frames, or the only density, are left out.
  const auto write = [&](const char* name, double known, const auto& value_of, const char* units,
                         const char* meaning) {
    std::vector<double> values;
    values.reserve(mesh.tetrahedra.size());
    for (std::size_t t = 0; t < mesh.tetrahedra.size(); ++t) values.push_back(value_of(t));
    if (std::ranges::count(values, known) == std::ssize(values)) return;
    write_column<double>(file, fmt::format("mesh/{}", name), values, std::identity(), units, meaning);
  };
  if (model.fracture.variation)
    write_column<double>(file, "mesh/strength_factor", fracture::strength_factors(model, content.sample, all),
                         std::identity(), "1",
                         "factor by which the variation multiplies the strength of each tetrahedron");
  if (!mesh.material.empty()) {
    write_column<std::uint8_t>(file, "mesh/material", mesh.material, std::identity(), "",
                               "number of the material of each tetrahedron");
    std::vector<std::string> names;
    for (const input::Material& material : model.materials) names.push_back(material.name);
    hdf5::write_attribute(file, "material_names", fmt::format("{}", fmt::join(names, "\n")));
  }
  if (model.map && model.map->has_file_per_sample())
    hdf5::write_attribute(file, "map", file_digest(model.map->path(content.sample)).value_or(""));
  if (!mesh.map_factor.empty())
    write_column<float>(file, "mesh/map_factor", mesh.map_factor, std::identity(), "1",
                        "factor of each tetrahedron by [material.map]");
  const auto material = fracture::make_material_field(model, content.sample, all);
  const input::Material& first = model.material();
  const auto number = [](std::size_t t) { return static_cast<std::int32_t>(t); };
  write(
      "youngs_modulus", mechanics::IsotropicElasticity(first).youngs_modulus(),
      [&](std::size_t t) { return material.elasticity[number(t)].youngs_modulus(); }, "Pa",
      "Young's modulus of each tetrahedron");
  write(
      "poisson_ratio", first.poisson_ratio,
      [&](std::size_t t) { return model.materials[all.material_of(t)].poisson_ratio; }, "1",
      "Poisson's ratio of each tetrahedron");
  write(
      "density", first.density, [&](std::size_t t) { return material.density[number(t)]; }, "kg/m^3",
      "density of each tetrahedron");
  // Frames are from the last dynamic phase.
  if (const double start = content.result.phase_start; !std::isnan(start))
    if (const auto strain = fracture::initial_strain_at(model, start, material.elasticity, all);
        !strain.empty())
      write_column<double>(file, "mesh/initial_strain", strain, std::identity(), "1",
                           "strain at which each tetrahedron is free of stress: xx, yy, zz, yz, xz, xy");
}

void write_counts(hid_t file, const dynamics::SampleCounts& counts) {
  const hdf5::Handle group = hdf5::create_group(file, "counts");
  for (const auto& [name, count] : {std::pair{"quasi_static_breaks", counts.quasi_static_breaks},
                                    {"static_solves", counts.static_solves},
                                    {"solver_iterations", counts.solver_iterations},
                                    {"dynamic_phases", counts.dynamic_phases},
                                    {"steps", counts.steps},
                                    {"force_evaluations", counts.force_evaluations},
                                    {"range_restarts", counts.range_restarts}})
    hdf5::write_scalar<std::int64_t>(group, name, count, "");
}

/// Writes identity, status and the sample's row. @return the group /summary
hdf5::Handle write_row(hid_t file, const input::Parameters& parameters, std::uint64_t sample,
                       const SampleSummary& summary) {
  write_identity(file, sample_kind, sample_schema_version, parameters);
  hdf5::write_attribute(file, "model_version", model_version);
  hdf5::write_attribute(file, "sample", sample);
  hdf5::write_attribute(file, "status", static_cast<std::int64_t>(summary.status));
  hdf5::write_attribute(file, "status_categories", analysis::status_categories);
  hdf5::write_attribute(file, "error", summary.error);
  hdf5::write_attribute(file, "note", summary.note);
  hdf5::Handle group = hdf5::create_group(file, "summary");
  int n_columns = 1;  // after the status
  analysis::for_each_result([&](const ResultInfo& info, auto member) {
    hdf5::write_scalar(group, info.name, summary.*member, info.units);
    describe_result(group, info.name, info, n_columns++);
  });
  analysis::for_each_position_result([&](const ResultInfo& info, auto member) {
    using Value = typename std::remove_cvref_t<decltype(summary.*member)>::value_type;
    hdf5::write_dataset<Value>(group, info.name, position_shape(parameters), summary.*member, info.units);
    describe_result(group, info.name, info, n_columns++);
  });
  hdf5::label_datasets(group, {"notch", "section"});
  if (!summary.crack_area_in.empty()) {
    const ResultInfo& info = analysis::crack_area_in_info;
    hdf5::write_dataset<double>(group, info.name, {summary.crack_area_in.size()}, summary.crack_area_in,
                                info.units);
    describe_parts(group, analysis::crack_parts(parameters.materials, parameters.interfaces), n_columns);
  }
  if (!summary.traces.empty()) {
    const hdf5::Handle traces = hdf5::create_group(group, "traces");
    analysis::for_each_trace_result([&](const ResultInfo& info, auto member) {
      write_column<double>(traces, info.name, summary.traces, member, info.units, info.meaning);
    });
  }
  if (!summary.fragments.heavier.empty()) {
    const hdf5::Handle fragments = hdf5::create_group(group, "fragments");
    analysis::for_each_fragment_result([&](const ResultInfo& info, auto member) {
      hdf5::write_scalar(fragments, info.name, summary.fragments.*member, info.units);
      describe_dataset(fragments, info.name, info.meaning);
    });
    write_column<double>(fragments, "heavier", summary.fragments.heavier, std::identity(), "",
                         analysis::heavier_meaning);
    write_column<double>(fragments, "shares", analysis::fragment_shares(), std::identity(), "1",
                         "of the body's mass");
    hdf5::label_dimensions(hdf5::open_dataset(fragments, "heavier"), std::vector<std::string>{"share"});
    hdf5::label_dimensions(hdf5::open_dataset(fragments, "shares"), std::vector<std::string>{"share"});
  }
  if (!summary.inputs.empty()) {
    const hdf5::Handle inputs = hdf5::create_group(group, "inputs");
    for (std::size_t k = 0; k < parameters.random.size(); ++k) {
      const input::RandomInput& random = parameters.random[k];
      hdf5::write_scalar(inputs, random.key, summary.inputs.at(k), units_of(random));
      describe_dataset(inputs, random.key, input::describe(random));
    }
  }
  return group;
}

hdf5::Handle write_timing(hid_t file, const SampleSummary& summary) {
  hdf5::Handle group = hdf5::create_group(file, "timing");
  hdf5::write_scalar<double>(group, "wall_time", summary.wall_time, "s");
  return group;
}

/// Fills a file in memory and writes it; errors name the file.
template <class Fill>
void write_file(const std::filesystem::path& path, Fill fill) {
  std::vector<std::byte> bytes;
  try {
    const hdf5::QuietErrors quiet;
    hdf5::MemoryFile file;
    fill(file);
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
    hdf5::write_scalar<double>(summary, "phase_start", result.phase_start, "s");
    hdf5::write_scalar<double>(summary, "time_step", result.time_step, "s");
    hdf5::write_scalar<double>(summary, "stable_step", result.stable_step, "s");
    if (const auto& scaling = result.mass_scaling) {
      hdf5::write_scalar<double>(summary, "added_mass_share", scaling->share, "1");
      hdf5::write_scalar<double>(summary, "added_mass_share_in_corridor", scaling->corridor_share, "1");
      hdf5::write_scalar<double>(summary, "nodes_with_added_mass_share", scaling->node_share, "1");
      hdf5::write_scalar<double>(summary, "step_gain", scaling->gain, "1");
    }
    const auto body = geometry::make_composite_body(content.parameters);
    const auto flaws = geometry::drawn_flaws(content.parameters, *body, content.sample);
    write_specimen(id, *body, flaws);
    write_pre_cracks(id, content.realization.pre_crack, flaws);
    write_mesh(id, content.realization);
    write_materials(id, content);
    write_crack_surface(id, content.surface, content.branches.branch, body->outline().empty());
    write_crack_lines(id, content.lines);
    write_branching(id, content.branches.points, body->outline().empty());
    write_crossings(id, content.crossings, content.parameters.sections.size());
    write_breaks(id, result.breaks);
    if (input::traits(content.parameters.fracture.release).by_cuts)
      write_bridge_releases(id, result.bridge_releases);
    if (content.parameters.fracture.softens()) write_stiffness_reductions(id, result.stiffness_reductions);
    write_plane_traces(id, content.surface, content.parameters.sections.planes);
    write_energy(id, result.energy);
    write_history(id, content.parameters, content.parameters.output.probes, result.history,
                  result.separated_at, content.crack_history);
    write_frames(id, result.frames, content.realization, content.parameters);
    write_fragments(id, result.fragments, result.fragment_history);
    write_counts(id, result.counts);
    const hdf5::Handle timing = write_timing(id, content.summary);
    hdf5::write_scalar<double>(timing, "mesh", result.timings.mesh, "s");
    hdf5::write_scalar<double>(timing, "setup", result.timings.setup, "s");
    hdf5::write_scalar<double>(timing, "quasi_static", result.timings.quasi_static, "s");
    hdf5::write_scalar<double>(timing, "dynamic", result.timings.dynamic, "s");
    hdf5::write_scalar<double>(timing, "ghost_seconds", result.timings.exchange_cost.seconds, "s");
    hdf5::write_scalar<std::int64_t>(timing, "ghost_exchanges", result.timings.exchange_cost.n_exchanges,
                                     "1");
    hdf5::write_scalar<std::int64_t>(timing, "ghost_bytes_per_exchange",
                                     result.timings.exchange_cost.bytes_per_exchange, "byte");
    hdf5::write_scalar<double>(timing, "element_updates_per_second",
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
