// SPDX-License-Identifier: GPL-3.0-or-later
#include "consistency.h"
#include "dimension.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <string>
#include <vector>

namespace crackle::input {

namespace {

std::string boundary_key(std::size_t i) {
  return fmt::format("boundary[{}]", i);
}

bool prescribes_motion(const Boundary& condition) {
  return condition.kind == BoundaryKind::fix || condition.kind == BoundaryKind::velocity ||
         condition.kind == BoundaryKind::displacement;
}

/// The part of its face that a condition holds on; along the face's normal the face's position twice.
Region part_of_face(const Boundary& condition, const Vector& size) {
  Region part;
  for (std::size_t axis = 0; axis < 3; ++axis) {
    part[axis] = {std::max(condition.region[axis].first, 0.0),
                  std::min(condition.region[axis].second, size[axis])};
  }
  const auto normal = static_cast<std::size_t>(axis_of(condition.on));
  const double position = is_upper(condition.on) ? size[normal] : 0;
  part[normal] = {position, position};
  return part;
}

void check_kind(const std::string& key, Findings& findings) {
  const std::vector<std::string> given = kinds_given(findings, key);
  if (given.empty()) {
    findings.report(key, "prescribes nothing; give one of fix, force, traction, velocity, displacement");
  } else if (given.size() > 1) {
    findings.report(key,
                    "gives {}; give exactly one of fix, force, traction, velocity, displacement, "
                    "and the others in a [[boundary]] of their own",
                    fmt::join(given, " and "));
  }
}

void check_course(const Boundary& condition, const std::string& key, Start start, Findings& findings) {
  const bool has_rate = findings.given(key + ".rate");
  const bool has_history = findings.given(key + ".history");
  if (condition.kind == BoundaryKind::fix && has_history) {
    findings.report(key + ".history",
                    "a fixed boundary does not change with time; give a displacement instead "
                    "of fix");
  } else if (has_rate && has_history) {
    findings.report(key + ".history", "is given besides rate; give one of the two");
  } else if (condition.kind == BoundaryKind::velocity && start != Start::rest && (has_rate || has_history)) {
    findings.report(key + (has_rate ? ".rate" : ".history"),
                    "a velocity that changes with time is not accepted unless start = \"rest\": the "
                    "quasi-static phase needs displacements that are linear in time between the points of a "
                    "history; give a constant velocity, or a displacement with a history");
  }
}

void check_region(const Boundary& condition, const std::string& key, const Specimen& specimen,
                  Findings& findings) {
  const auto normal = static_cast<std::size_t>(axis_of(condition.on));
  const double position = is_upper(condition.on) ? specimen.size[normal] : 0;
  const auto [lower, upper] = condition.region[normal];
  const double tolerance = 1e-9 * specimen.size[normal];
  if (position < lower - tolerance || position > upper + tolerance) {
    findings.report(key + ".region." + axis_names[normal],
                    "the face lies at {} = {}, outside the region from {} to {}", axis_names[normal],
                    show(position), show(lower), show(upper));
    return;
  }
  const Region part = part_of_face(condition, specimen.size);
  for (std::size_t axis = 0; axis < 3; ++axis) {
    if (axis != normal && part[axis].first >= part[axis].second) {
      findings.report(key + ".region." + axis_names[axis],
                      "the region from {} to {} misses the face; give a part of 0 to {}",
                      show(condition.region[axis].first), show(condition.region[axis].second),
                      show(specimen.size[axis]));
      return;
    }
  }
  for (std::size_t i = 0; i < specimen.notches.size(); ++i) {
    const std::string notch = fmt::format("specimen.notch[{}]", i);
    if (specimen.notches[i].face != condition.on || findings.faulty(notch)) continue;
    const Region slot = slot_of(specimen.notches[i], specimen.size);
    bool inside = true;
    for (std::size_t axis = 0; axis < 3; ++axis) {
      inside = inside && part[axis].first >= slot[axis].first && part[axis].second <= slot[axis].second;
    }
    if (inside) {
      findings.report(key + ".region", "lies in the mouth of {}, where there is no face", notch);
    }
  }
}

/// Two conditions that prescribe the same component of the same points, other than to fix it twice.
void check_conflicts(const Parameters& parameters, std::size_t i, Findings& findings) {
  const Boundary& condition = parameters.boundaries[i];
  const Region part = part_of_face(condition, parameters.specimen.size);
  const auto normal = static_cast<std::size_t>(axis_of(condition.on));
  for (std::size_t j = 0; j < i; ++j) {
    const Boundary& other = parameters.boundaries[j];
    if (other.on != condition.on || findings.faulty(boundary_key(j)) || !prescribes_motion(other)) continue;
    if (condition.kind == BoundaryKind::fix && other.kind == BoundaryKind::fix) continue;
    const Region other_part = part_of_face(other, parameters.specimen.size);
    bool overlap = true;
    std::vector<std::string> shared;
    for (std::size_t axis = 0; axis < 3; ++axis) {
      if (axis != normal) {
        overlap = overlap && std::max(part[axis].first, other_part[axis].first) <
                                 std::min(part[axis].second, other_part[axis].second);
      }
      if (condition.components[axis] && other.components[axis]) shared.emplace_back(axis_names[axis]);
    }
    if (overlap && !shared.empty()) {
      findings.report(boundary_key(i),
                      "prescribes the motion in {} of points that {} prescribes too; "
                      "give each component once",
                      fmt::join(shared, " and "), boundary_key(j));
      return;
    }
  }
}

void check_held_in_all_directions(const Parameters& parameters, Findings& findings) {
  std::vector<std::string> loose;
  for (std::size_t axis = 0; axis < 3; ++axis) {
    const auto is_held = std::ranges::any_of(parameters.boundaries, [&](const Boundary& condition) {
      return prescribes_motion(condition) && condition.components[axis];
    });
    if (!is_held) loose.emplace_back(axis_names[axis]);
  }
  if (loose.empty()) return;
  findings.report("boundary",
                  "nothing holds the body in {}, and with start = \"quasi-static\" it must be in "
                  "equilibrium; give a fix, displacement or velocity for each of x, y and z",
                  fmt::join(loose, " and "));
}

}  // namespace

std::vector<std::string> kinds_given(const Findings& findings, const std::string& table) {
  std::vector<std::string> given;
  for (const char* kind : kind_names)
    if (findings.given(fmt::format("{}.{}", table, kind))) given.emplace_back(kind);
  return given;
}

void check_boundaries(const Parameters& parameters, Findings& findings) {
  if (parameters.boundaries.empty()) {
    if (!findings.faulty("boundary")) {
      findings.report("boundary", "the body has no boundary condition; give at least one table [[boundary]]");
    }
    return;
  }
  const bool size_known = !findings.faulty("specimen.size");
  for (std::size_t i = 0; i < parameters.boundaries.size(); ++i) {
    const std::string key = boundary_key(i);
    const Boundary& condition = parameters.boundaries[i];
    check_kind(key, findings);
    if (findings.faulty(key)) continue;
    check_course(condition, key, parameters.time.start, findings);
    if (size_known) check_region(condition, key, parameters.specimen, findings);
    if (size_known && prescribes_motion(condition) && !findings.faulty(key)) {
      check_conflicts(parameters, i, findings);
    }
  }
  if (parameters.time.start != Start::rest && !findings.faulty("boundary") &&
      !findings.faulty("time.start")) {
    check_held_in_all_directions(parameters, findings);
  }
}

}  // namespace crackle::input
