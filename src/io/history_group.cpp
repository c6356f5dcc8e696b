// SPDX-License-Identifier: GPL-3.0-or-later
#include "history_group.h"

#include "crackle/mechanics/elasticity.h"

#include "columns.h"

#include <fmt/format.h>

#include <initializer_list>
#include <string>

namespace crackle::io {

namespace {

using dynamics::HistoryRow;

/// A table of vectors, rows x `n_columns`.
template <class Columns, class Of>
void write_vectors(hid_t group, const char* name, const std::vector<HistoryRow>& rows, std::size_t n_columns,
                   Columns columns, Of value_of, const char* units, const char* meaning) {
  std::vector<double> values;
  std::size_t n_components = 0;
  for (const HistoryRow& row : rows)
    for (const auto& one : row.*columns) hdf5::flatten(std::invoke(value_of, one), values);
  using Value = std::remove_cvref_t<std::invoke_result_t<
      Of, const typename std::remove_cvref_t<decltype(rows.front().*columns)>::value_type&>>;
  n_components = std::tuple_size_v<Value>;
  hdf5::write_dataset<double>(group, name, {rows.size(), n_columns, n_components}, values, units,
                              hdf5::Storage::compressed);
  describe_dataset(group, name, meaning);
}

void label_as(hid_t group, std::initializer_list<const char*> datasets,
              const std::vector<std::string>& names) {
  for (const char* name : datasets) hdf5::label_dimensions(hdf5::open_dataset(group, name), names);
}

void write_conditions(hid_t history, const std::vector<input::Boundary>& conditions,
                      const std::vector<HistoryRow>& rows) {
  const hdf5::Handle group = hdf5::create_group(history, "conditions");
  std::vector<std::string> names, kinds;
  for (const input::Boundary& condition : conditions) {
    names.push_back(condition.on);
    kinds.push_back(input::name_of(condition.kind));
  }
  hdf5::write_texts(group, "on", names);
  describe_dataset(group, "on", "face of each boundary condition, in the order of the input");
  hdf5::write_texts(group, "kind", kinds);
  describe_dataset(group, "kind", "what it prescribes");
  write_vectors(group, "force", rows, conditions.size(), &HistoryRow::force, std::identity(), "N",
                "that each condition exerts on the body (x, y, z): the applied force or the reaction");
  write_vectors(group, "displacement", rows, conditions.size(), &HistoryRow::displacement, std::identity(),
                "m", "mean over the loaded area, or over the held nodes, of each condition (x, y, z)");
  hdf5::label_datasets(group, {"moment", "condition", "component"});
  label_as(group, {"on", "kind"}, {"condition"});
}

void write_probes(hid_t history, const std::vector<input::Probe>& probes,
                  const std::vector<HistoryRow>& rows) {
  using dynamics::ProbeValue;
  const hdf5::Handle group = hdf5::create_group(history, "probes");
  std::vector<std::string> names;
  std::vector<double> places;
  for (const input::Probe& probe : probes) {
    names.push_back(probe.name);
    hdf5::flatten(probe.at, places);
  }
  hdf5::write_texts(group, "name", names);
  hdf5::write_dataset<double>(group, "at", {probes.size(), 3}, places, "m");
  write_vectors(group, "displacement", rows, probes.size(), &HistoryRow::probes, &ProbeValue::displacement,
                "m", "interpolated (x, y, z)");
  write_vectors(group, "velocity", rows, probes.size(), &HistoryRow::probes, &ProbeValue::velocity, "m/s",
                "interpolated (x, y, z); 0 in quasi-static loading");
  write_vectors(group, "stress", rows, probes.size(), &HistoryRow::probes, &ProbeValue::stress, "Pa",
                "interpolated between nodal means (xx, yy, zz, yz, xz, xy)");
  hdf5::label_datasets(group, {"moment", "probe", "component"});
  label_as(group, {"name", "at"}, {"probe", "component"});
  label_as(group, {"stress"}, {"moment", "probe", "stress_component"});
}

void write_cracks(hid_t group, const analysis::CrackHistory& cracks, std::size_t n_rows) {
  const auto write = [&](const char* name, const std::vector<double>& values, const char* units,
                         const char* meaning) {
    hdf5::write_dataset<double>(group, name, {n_rows, cracks.n_starts}, values, units,
                                hdf5::Storage::compressed);
    describe_dataset(group, name, meaning);
  };
  write("crack_area", cracks.area, "m^2", "of all opened dual facets of each crack start's cracks");
  write("crack_length", cracks.length, "m",
        "of each crack start's longest crack line, along it, up to the tip");
  write("tip_speed", cracks.speed, "m/s", "of that tip, through-thickness mean; NaN where it does not run");
  write("energy_release_rate", cracks.release_rate, "J/m^2",
        "energy that is released while the tip advances, over the area of the advance; NaN likewise");
}

}  // namespace

void write_history(hid_t file, const input::Parameters& parameters, const std::vector<HistoryRow>& rows,
                   const analysis::CrackHistory& cracks) {
  const hdf5::Handle group = hdf5::create_group(file, "history");
  write_column<double>(group, "load_time", rows, &HistoryRow::load_time, "s",
                       "of the load curves: in a dynamic phase its start plus the time since");
  write_column<std::int32_t>(group, "phase", rows, &HistoryRow::phase, "",
                             "number of the dynamic phase; 0 in quasi-static loading");
  const auto energy = [&](const char* name, auto member, const char* units, const char* meaning) {
    write_column<double>(
        group, name, rows, [&](const HistoryRow& row) { return row.energy.*member; }, units, meaning);
  };
  using dynamics::EnergyRow;
  energy("phase_time", &EnergyRow::time, "s", "since the start of the dynamic phase");
  write_column<double>(group, "load", rows, &HistoryRow::load, "N",
                       "the largest force or reaction of any condition that loads the body");
  write_column<double>(group, "load_displacement", rows, &HistoryRow::load_displacement, "m",
                       "where that load acts, in its direction");
  energy("kinetic", &EnergyRow::kinetic, "J", "energy in motion");
  energy("strain", &EnergyRow::strain, "J", "energy in strain");
  energy("external", &EnergyRow::external, "J", "work of the loads");
  energy("released", &EnergyRow::released, "J", "energy that breaking took");
  energy("dissipated", &EnergyRow::dissipated, "J", "energy that coming to rest took");
  write_column<std::int64_t>(
      group, "broken", rows, [](const HistoryRow& row) { return row.energy.broken; }, "",
      "tetrahedra broken so far");
  if (cracks.area.size() == rows.size() * cracks.n_starts) write_cracks(group, cracks, rows.size());
  hdf5::label_datasets(group, {"moment", "notch"}, "load_time");
  hdf5::write_attribute(group, "rayleigh_speed", mechanics::rayleigh_speed(parameters.material));
  write_conditions(group, parameters.boundaries, rows);
  if (!parameters.output.probes.empty()) write_probes(group, parameters.output.probes, rows);
}

}  // namespace crackle::io
