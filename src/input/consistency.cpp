// SPDX-License-Identifier: GPL-3.0-or-later
#include "consistency.h"

#include "crackle/input/limits.h"
#include "dimension.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

namespace crackle::input {

namespace {

/// Planes nearer to each other than this part of the body's size count as touching.
constexpr double touching = 1e-6;

std::string show(double length) {
  return format_quantity(length, length_dimension());
}

/// To two figures, for advice.
double rounded_up(double value) {
  const double unit = std::pow(10, std::floor(std::log10(value)) - 1);
  return std::ceil(value / unit) * unit;
}

std::string notch_key(std::size_t i) {
  return fmt::format("specimen.notch[{}]", i);
}

const char* extent_name(int axis) {
  return axis == 0 ? "thickness" : axis == 1 ? "width" : "length";
}

void check_notch_in_body(const Notch& notch, const std::string& key, const Vector& size, Findings& findings) {
  const int depth_axis = axis_of(notch.face);
  const int axis = position_axis(notch.face);
  const double depth_extent = size[static_cast<std::size_t>(depth_axis)];
  const double extent = size[static_cast<std::size_t>(axis)];
  if (!findings.faulty(key + ".depth") && notch.depth >= depth_extent * (1 - touching)) {
    findings.report(key + ".depth",
                    fmt::format("{} cuts the body in two; give less than its {} of {}", show(notch.depth),
                                extent_name(depth_axis), show(depth_extent)));
  }
  if (findings.faulty(key + ".at") || findings.faulty(key + ".height")) return;
  if (notch.height >= extent * (1 - 2 * touching)) {
    findings.report(key + ".height", fmt::format("{} leaves nothing of the body; give less than its {} of {}",
                                                 show(notch.height), extent_name(axis), show(extent)));
    return;
  }
  if (notch.at - notch.height / 2 <= extent * touching ||
      notch.at + notch.height / 2 >= extent * (1 - touching)) {
    findings.report(
        key + ".at",
        fmt::format(
            "a slot of height {} at {} does not stay inside the body; give a position between {} and {}",
            show(notch.height), show(notch.at), show(notch.height / 2), show(extent - notch.height / 2)));
  }
}

/// Of the body without its notches, which must not overlap [m^3].
double material_volume(const Specimen& specimen) {
  const Vector& size = specimen.size;
  double volume = size[0] * size[1] * size[2];
  for (const Notch& notch : specimen.notches) {
    double slot_volume = 1;
    for (const auto& [from, to] : slot_of(notch, size)) slot_volume *= to - from;
    volume -= slot_volume;
  }
  return volume;
}

}  // namespace

std::array<std::pair<double, double>, 3> slot_of(const Notch& notch, const Vector& size) {
  std::array<std::pair<double, double>, 3> slot;
  slot[0] = {0, size[0]};
  const auto depth_axis = static_cast<std::size_t>(axis_of(notch.face));
  const double extent = size[depth_axis];
  slot[depth_axis] =
      is_upper(notch.face) ? std::pair{extent - notch.depth, extent} : std::pair{0.0, notch.depth};
  slot[static_cast<std::size_t>(position_axis(notch.face))] = {notch.at - notch.height / 2,
                                                               notch.at + notch.height / 2};
  return slot;
}

void check_specimen(const Parameters& parameters, Findings& findings) {
  if (findings.faulty("specimen.size")) return;
  const Vector& size = parameters.specimen.size;
  const auto& notches = parameters.specimen.notches;
  for (std::size_t i = 0; i < notches.size(); ++i) {
    if (findings.faulty(notch_key(i) + ".face")) continue;
    check_notch_in_body(notches[i], notch_key(i), size, findings);
    if (findings.faulty(notch_key(i))) continue;
    const auto slot = slot_of(notches[i], size);
    for (std::size_t j = 0; j < i; ++j) {
      if (findings.faulty(notch_key(j))) continue;
      const auto other = slot_of(notches[j], size);
      bool meet = true;
      for (std::size_t axis = 0; axis < 3; ++axis) {
        const double gap =
            std::max(slot[axis].first - other[axis].second, other[axis].first - slot[axis].second);
        meet = meet && gap <= touching * size[axis];
      }
      if (meet) {
        findings.report(
            notch_key(i),
            fmt::format("touches or overlaps {}; leave material between the notches", notch_key(j)));
        break;
      }
    }
  }
}

void check_mesh(const Parameters& parameters, Findings& findings) {
  const Mesh& mesh = parameters.mesh;
  if (findings.faulty("mesh.spacing")) return;
  if (!findings.faulty("mesh.notch_spacing") && mesh.notch_spacing > mesh.spacing) {
    findings.report("mesh.notch_spacing", fmt::format("{} is over mesh.spacing; give at most {}",
                                                      show(mesh.notch_spacing), show(mesh.spacing)));
  }
  if (findings.faulty("specimen.size")) return;
  const Vector& size = parameters.specimen.size;
  const double smallest = *std::min_element(size.begin(), size.end());
  if (mesh.spacing > smallest) {
    findings.report("mesh.spacing", fmt::format("{} is over the smallest edge of the body; give at most {}",
                                                show(mesh.spacing), show(smallest)));
    return;
  }
  if (findings.faulty("specimen.notch")) return;
  // At least one mother point stands in each spacing^3; finer spacings near notches are counted when the mesh
  // is made.
  const double volume = material_volume(parameters.specimen);
  const double n_points = volume / std::pow(mesh.spacing, 3);
  if (!(n_points <= max_mother_points) && !mesh.points) {
    findings.report(
        "mesh.spacing",
        fmt::format("{} gives {:.0e} mother points or more, and at most {:.0e} can be made; give at least {}",
                    show(mesh.spacing), n_points, max_mother_points,
                    show(rounded_up(std::cbrt(volume / max_mother_points)))));
  }
}

void check_sections(const Parameters& parameters, Findings& findings) {
  const std::vector<double>& y = parameters.sections.y;
  for (std::size_t i = 0; i < y.size(); ++i) {
    const std::string key = fmt::format("sections.y[{}]", i);
    if (findings.faulty(key)) continue;
    const double width = parameters.specimen.size[1];
    if (!findings.faulty("specimen.size") && !(y[i] > 0 && y[i] < width)) {
      findings.report(key, fmt::format("{} is not inside the width; give a length between 0 and {}",
                                       show(y[i]), show(width)));
    } else if (i > 0 && y[i] <= y[i - 1]) {
      findings.report(key, fmt::format("{} is not above {} before it; give ascending lengths", show(y[i]),
                                       show(y[i - 1])));
    }
  }
}

void check_fracture(const Parameters& parameters, Findings& findings) {
  if (parameters.fracture.contact == Contact::frictionless && parameters.time.start != Start::rest)
    findings.report(
        "fracture.contact",
        "\"frictionless\" is for dynamics only, equilibria are linear; give time.start = \"rest\"");
  if (findings.faulty("fracture.strength") || findings.faulty("fracture.toughness")) return;
  const Fracture& fracture = parameters.fracture;
  if (fracture.strength == 0 && fracture.toughness == 0) {
    findings.report("fracture.strength",
                    "the key is missing; give a strength such as \"35 MPa\", or toughness");
  } else if (fracture.strength != 0 && fracture.toughness != 0) {
    findings.report("fracture.toughness", "is given besides strength; give one of the two");
  }
}

void check_time(const Parameters& parameters, Findings& findings) {
  const Time& time = parameters.time;
  if (!time.step || findings.faulty("time.step") || findings.faulty("time.duration")) return;
  constexpr double max_steps = 1e9;
  const std::string duration = format_quantity(time.duration, time_dimension());
  const std::string step = format_quantity(*time.step, time_dimension());
  if (*time.step > time.duration) {
    findings.report("time.step", fmt::format("{} is over the duration; give at most {}", step, duration));
  } else if (time.duration / *time.step > max_steps) {
    findings.report("time.step", fmt::format("{} makes more than {:.0e} steps in {}; give a longer step",
                                             step, max_steps, duration));
  }
}

}  // namespace crackle::input
