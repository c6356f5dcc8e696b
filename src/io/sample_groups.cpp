// SPDX-License-Identifier: GPL-3.0-or-later
#include "sample_groups.h"

#include "mechanics/elasticity.h"
#include "mechanics/governing_condition.h"

#include <fmt/format.h>

#include <initializer_list>

namespace crackle::io {

namespace {

using dynamics::HistoryRow;

/// Writes a table of vectors, one per moment and column: rows x `n_columns` x components.
/// @param value_of gives the vector of a column at a moment
template <class Of>
void write_vectors(hid_t group, const char* name, const std::vector<HistoryRow>& rows, std::size_t n_columns,
                   const Of& value_of, const char* units, const char* meaning) {
  std::vector<double> values;
  for (const HistoryRow& row : rows)
    for (std::size_t k = 0; k < n_columns; ++k) hdf5::flatten(value_of(row, k), values);
  constexpr std::size_t n_components =
      std::tuple_size_v<std::remove_cvref_t<std::invoke_result_t<Of, const HistoryRow&, std::size_t>>>;
  hdf5::write_dataset<double>(group, name, {rows.size(), n_columns, n_components}, values, units,
                              hdf5::Storage::compressed);
  describe_dataset(group, name, meaning);
}

void label_as(hid_t group, std::initializer_list<const char*> datasets,
              const std::vector<std::string>& names) {
  for (const char* name : datasets) hdf5::label_dimensions(hdf5::open_dataset(group, name), names);
}

/// The boundary conditions, then the body forces.
void write_conditions(hid_t group, const input::Model& model, const std::vector<HistoryRow>& rows) {
  std::vector<std::string> faces, names, kinds;
  std::vector<bool> are_loads;
  for (const input::Boundary& condition : model.boundaries) {
    faces.push_back(condition.on);
    names.push_back(condition.name);
    kinds.emplace_back(input::name_of(condition.kind));
    are_loads.push_back(input::traits(condition.kind).action == input::Action::load);
  }
  for (const input::BodyLoad& load : model.body_forces()) {
    faces.emplace_back("body");
    names.emplace_back();
    kinds.emplace_back(input::name_of(load.kind));
    are_loads.push_back(true);
  }
  hdf5::write_texts(group, "condition_on", faces);
  describe_dataset(
      group, "condition_on",
      "face of each boundary condition, in the order of the input; then \"body\" for each force of [[load]]");
  hdf5::write_texts(group, "condition_name", names);
  describe_dataset(group, "condition_name",
                   "conditions with the same name count as one load; empty if unnamed");
  hdf5::write_texts(group, "condition_kind", kinds);
  describe_dataset(group, "condition_kind", "prescribed quantity");
  const auto force_of = [&](bool of_loads) {
    return [&are_loads, of_loads](const HistoryRow& row, std::size_t k) {
      return are_loads[k] == of_loads ? row.force[k] : Vector{};
    };
  };
  write_vectors(group, "load", rows, faces.size(), force_of(true), "N",
                "force that each condition applies to the body (x, y, z); 0 where it prescribes a motion");
  write_vectors(
      group, "reaction", rows, faces.size(), force_of(false), "N",
      "force that each prescribed motion or absorbing face exerts on the body (x, y, z); 0 for loads");
  write_vectors(
      group, "displacement", rows, faces.size(),
      [](const HistoryRow& row, std::size_t k) { return row.displacement[k]; }, "m",
      "mean over the loaded area, or over the constrained nodes, of each condition (x, y, z)");
}

/// Writes a group for each probe, by its name.
void write_probes(hid_t history, const std::vector<input::Probe>& probes,
                  const std::vector<HistoryRow>& rows) {
  using dynamics::ProbeValue;
  const hdf5::Handle all = hdf5::create_group(history, "probes");
  for (std::size_t k = 0; k < probes.size(); ++k) {
    const hdf5::Handle group = hdf5::create_group(all, probes[k].name);
    const auto write = [&]<class Member>(const char* name, Member member, const char* units,
                                         const char* meaning) {
      write_column<double>(
          group, name, rows, [&](const HistoryRow& row) { return row.probes[k].*member; }, units, meaning);
    };
    write("displacement", &ProbeValue::displacement, "m", "interpolated (x, y, z)");
    write("velocity", &ProbeValue::velocity, "m/s", "interpolated (x, y, z); 0 in quasi-static loading");
    write("stress", &ProbeValue::stress, "Pa", "interpolated between nodal means (xx, yy, zz, yz, xz, xy)");
    hdf5::label_datasets(group, {"moment", "component"});
    label_as(group, {"stress"}, {"moment", "stress_component"});
    hdf5::write_dataset<double>(group, "at", {3}, probes[k].at, "m");
    label_as(group, {"at"}, {"component"});
  }
}

/// Writes a group for each tool, by its name.
void write_tools(hid_t history, const std::vector<input::Tool>& tools, const std::vector<HistoryRow>& rows) {
  using dynamics::ToolState;
  const hdf5::Handle all = hdf5::create_group(history, "tools");
  for (std::size_t t = 0; t < tools.size(); ++t) {
    const hdf5::Handle group = hdf5::create_group(all, name_of(tools[t], t));
    const auto write = [&]<class Member>(const char* name, Member member, const char* units,
                                         const char* meaning) {
      write_column<double>(
          group, name, rows, [&](const HistoryRow& row) { return row.tools[t].*member; }, units, meaning);
    };
    write("position", &ToolState::position, "m", "of the point `at` of the input (x, y, z)");
    write("displacement", &ToolState::displacement, "m", "since the start (x, y, z)");
    write("velocity", &ToolState::velocity, "m/s", "(x, y, z); 0 in equilibrium unless it is prescribed");
    write("reaction", &ToolState::reaction, "N", "force on the body (x, y, z)");
    label_as(group, {"position", "displacement", "velocity", "reaction"}, {"moment", "component"});
    if (tools[t].turns()) {
      write("orientation", &ToolState::orientation, "1",
            "unit quaternion that turns the tool from its place at the start (w, x, y, z); 1, 0, 0, 0 in "
            "equilibrium");
      write("angular_velocity", &ToolState::angular_velocity, "rad/s",
            "angular velocity (x, y, z); 0 in equilibrium");
      label_as(group, {"orientation"}, {"moment", "quaternion"});
      label_as(group, {"angular_velocity"}, {"moment", "component"});
    }
    write("friction_work", &ToolState::friction_work, "J",
          "energy lost by friction so far, in dynamic phases since the start of the phase");
    label_as(group, {"friction_work"}, {"moment"});
  }
}

/// Writes what tools are, as attributes of a group for each.
void write_tool_shapes(hid_t file, const std::vector<input::Tool>& tools) {
  const hdf5::Handle all = hdf5::create_group(file, "tools");
  for (std::size_t t = 0; t < tools.size(); ++t) {
    const input::Tool& tool = tools[t];
    const hdf5::Handle group = hdf5::create_group(all, name_of(tool, t));
    const auto write = [&](const char* name, const auto& values) {
      hdf5::write_attribute<double>(group, name, std::span<const double>(values), {std::size(values)});
    };
    hdf5::write_attribute(group, "shape",
                          std::string(input::tool_shape_names[static_cast<std::size_t>(tool.shape)]));
    write("at", tool.at);
    if (tool.axis != Vector{}) write("axis", tool.axis);
    if (!tool.size.empty()) write("size", tool.size);
    hdf5::write_attribute(group, "radius", tool.radius);
    hdf5::write_attribute(group, "rounding", tool.rounding);
    hdf5::write_attribute(group, "mass", tool.mass);
  }
}

/// Writes a dataset for each quantity that terms record, by its name.
void write_records(hid_t history, const std::vector<HistoryRow>& rows) {
  const hdf5::Handle group = hdf5::create_group(history, "terms");
  for (std::size_t k = 0; k < rows.front().records.size(); ++k) {
    const auto& [name, unit, meaning, first] = rows.front().records[k];
    write_column<double>(
        group, name, rows, [&](const HistoryRow& row) { return row.records.at(k).value; }, unit, meaning);
  }
  hdf5::label_datasets(group, {"moment"});
}

/// Writes tables of values, by moment and column.
auto writer(hid_t group, std::size_t n_rows, std::size_t n_columns) {
  return [=](const char* name, const std::vector<double>& values, const char* units, const char* meaning) {
    hdf5::write_dataset<double>(group, name, {n_rows, n_columns}, values, units, hdf5::Storage::compressed);
    describe_dataset(group, name, meaning);
  };
}

void write_cracks(hid_t group, const cracks::CrackHistory& cracks, std::size_t n_rows) {
  const auto write = writer(group, n_rows, cracks.n_starts);
  write("crack_area", cracks.area, "m^2",
        "area of all opened dual facets of the cracks from each crack start");
  write("crack_length", cracks.length, "m",
        "length of the longest crack from each crack start, along its path up to its tip");
  write("tip_speed", cracks.speed, "m/s",
        "speed of that tip along its path, through-thickness mean over a tenth of the ligament; NaN while it "
        "does not advance");
  write("tip_speed_ratio", cracks.speed_ratio, "1",
        "ratio of that speed to the Rayleigh speed of what breaks there; NaN likewise");
  write("energy_release_rate", cracks.release_rate, "J/m^2",
        "energy released while the tip advances, per area of the advance along its path; NaN likewise");
}

/// The group /history/cracks.
void write_cracks_in_space(hid_t history, const cracks::CracksInSpace& cracks, std::size_t n_rows) {
  const hdf5::Handle group = hdf5::create_group(history, "cracks");
  const auto write = writer(group, n_rows, cracks.area.size() / n_rows);
  write("area", cracks.area, "m^2", "area of all opened dual facets of each crack");
  write("reach", cracks.reach, "m", "greatest distance of these from the facet that opened first");
  write("speed", cracks.speed, "m/s",
        "at which the reach grows in the last dynamic phase; NaN where it does not");
  hdf5::label_datasets(group, {"moment", "crack"});
}

}  // namespace

void write_history(hid_t file, const input::Model& model, const std::vector<input::Probe>& probes,
                   const std::vector<HistoryRow>& rows, double separated_at,
                   const cracks::CrackHistory& cracks) {
  const hdf5::Handle group = hdf5::create_group(file, "history");
  write_column<double>(group, "time", rows, &HistoryRow::load_time, "s",
                       "time of the load curves: in a dynamic phase, its start plus the time since then");
  write_column<std::int32_t>(group, "phase", rows, &HistoryRow::phase, "",
                             "number of the dynamic phase; 0 in quasi-static loading");
  const auto energy = [&](const char* name, auto member, const char* units, const char* meaning) {
    write_column<double>(
        group, name, rows, [&](const HistoryRow& row) { return row.energy.*member; }, units, meaning);
  };
  using dynamics::EnergyRow;
  energy("phase_time", &EnergyRow::time, "s", "since the start of the dynamic phase");
  write_column<double>(
      group, "governing_load", rows, &HistoryRow::load, "N",
      "load of the testing machine: force of the governing conditions, along the loading direction");
  write_column<double>(group, "governing_displacement", rows, &HistoryRow::load_displacement, "m",
                       "displacement of these conditions, along the loading direction");
  energy("kinetic", &EnergyRow::kinetic, "J", "kinetic energy");
  energy("strain", &EnergyRow::strain, "J", "strain energy");
  energy("external", &EnergyRow::external, "J", "work of the loads");
  energy("released", &EnergyRow::released, "J", "energy released by breaking");
  energy("dissipated", &EnergyRow::dissipated, "J",
         "energy dissipated by damping, absorbing faces and arrest");
  write_column<std::int64_t>(
      group, "broken", rows, [](const HistoryRow& row) { return row.energy.broken; }, "",
      "tetrahedra broken so far");
  if (cracks.area.size() == rows.size() * cracks.n_starts) write_cracks(group, cracks, rows.size());
  if (!cracks.in_space.area.empty()) write_cracks_in_space(group, cracks.in_space, rows.size());
  write_conditions(group, model, rows);
  hdf5::label_datasets(group, {"moment", "notch"}, "time");
  label_as(group, {"load", "reaction", "displacement"}, {"moment", "condition", "component"});
  label_as(group, {"condition_on", "condition_kind", "condition_name"}, {"condition"});
  std::vector<std::int32_t> governing;
  for (const auto& one : mechanics::governing_conditions(model)) governing.push_back(one.condition);
  if (!governing.empty())
    hdf5::write_attribute<std::int32_t>(group, "governing", governing, {governing.size()});
  hdf5::write_attribute(group, "separated_at", separated_at);
  hdf5::write_attribute(group, "rayleigh_speed", cracks.rayleigh_speed);
  if (!probes.empty()) write_probes(group, probes, rows);
  if (!rows.empty() && !rows.front().records.empty()) write_records(group, rows);
  if (!rows.empty() && !rows.front().tools.empty()) write_tools(group, model.tools, rows);
  if (!model.tools.empty()) write_tool_shapes(file, model.tools);
}

}  // namespace crackle::io
