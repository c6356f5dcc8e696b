// SPDX-License-Identifier: GPL-3.0-or-later
#include "consistency.h"

#include "common/index.h"

#include "dimension.h"

#include <fmt/format.h>

#include <algorithm>
#include <utility>

namespace crackle::input {

namespace {

std::string notch_key(std::size_t i) {
  return fmt::format("specimen.notch[{}]", i);
}

const char* extent_name(int axis) {
  return axis == 0 ? "thickness" : axis == 1 ? "width" : "length";
}

void check_notch_in_body(const plane::Notch& notch, const std::string& key, const Vector& size,
                         Findings& findings) {
  const int depth_axis = axis_of(notch.face);
  const int axis = position_axis(notch.face);
  const double depth_extent = size[index(depth_axis)];
  const double extent = size[index(axis)];
  if (!findings.faulty(key + ".depth") && notch.depth >= depth_extent * (1 - touching)) {
    findings.report(key + ".depth", "{} cuts the body in two; give less than the body's {} of {}",
                    show(notch.depth), extent_name(depth_axis), show(depth_extent));
  }
  if (findings.faulty(key + ".at") || findings.faulty(key + ".height")) return;
  if (notch.height >= extent * (1 - 2 * touching)) {
    findings.report(key + ".height", "{} leaves nothing of the body; give less than the body's {} of {}",
                    show(notch.height), extent_name(axis), show(extent));
    return;
  }
  if (notch.at - notch.height / 2 <= extent * touching ||
      notch.at + notch.height / 2 >= extent * (1 - touching)) {
    findings.report(
        key + ".at",
        "a slot of height {} at {} does not fit inside the body; give a position between {} and {}",
        show(notch.height), show(notch.at), show(notch.height / 2), show(extent - notch.height / 2));
  }
}

/// The extent that a notch's crack can reach along the axis of its depth: from the tip to the opposite face,
/// as it can pass another notch.
std::pair<double, double> reach_of(const plane::Notch& notch, const plane::Region& bounds) {
  const auto axis = index(axis_of(notch.face));
  const plane::Region slot = slot_of(notch, bounds);
  return is_upper(notch.face) ? std::pair{bounds[axis].first, slot[axis].first}
                              : std::pair{slot[axis].second, bounds[axis].second};
}

/// The extents that notch cracks advancing along an axis can reach, for advice: "between 6 mm and 24.5 mm
/// (specimen.notch[0])", each extent once; empty if there are none.
std::string describe_ligaments(const plane::Specimen& specimen, int axis) {
  constexpr std::size_t max_shown = 4;
  std::vector<std::string> extents;
  std::string text;
  for (std::size_t i = 0; i < specimen.notches.size(); ++i) {
    if (axis_of(specimen.notches[i].face) != axis) continue;
    const auto [from, to] = reach_of(specimen.notches[i], bounds_of(specimen));
    const std::string extent = fmt::format("between {} and {}", from == 0 ? "0" : show(from), show(to));
    if (std::ranges::find(extents, extent) != extents.end()) continue;
    if (extents.size() < max_shown)
      text += fmt::format("{}{} ({})", extents.empty() ? "" : " or ", extent, notch_key(i));
    if (extents.size() == max_shown) text += " ...";
    extents.push_back(extent);
  }
  return text;
}

bool can_arrive(const plane::Specimen& specimen, int axis, double position) {
  const double gap = touching * specimen.size[index(axis)];
  return std::ranges::any_of(specimen.notches, [&](const plane::Notch& notch) {
    if (axis_of(notch.face) != axis) return false;
    const auto [from, to] = reach_of(notch, bounds_of(specimen));
    return position > from + gap && position < to - gap;
  });
}

/// Unreachable sections of a single sample are allowed, and have no crossings.
void check_sections_along(int axis, const std::vector<double>& positions, const std::string& name,
                          const Parameters& parameters, Findings& findings) {
  const plane::Specimen& specimen = parameters.specimen;
  const auto [lower, upper] = bounds_of(specimen)[index(axis)];
  const bool has_size = size_is_known(findings);
  // A body without notches has no crack paths, so its sections are not checked.
  const bool has_notches = has_size && is_box(specimen) && !findings.faulty("specimen.notch") &&
                           !specimen.notches.empty() && specimen.cracks.empty() && parameters.flaws.empty();
  const std::string ligaments = has_notches ? describe_ligaments(specimen, axis) : "";
  if (has_notches && ligaments.empty() && !positions.empty()) {
    const char* axis_name = axis == 1 ? "y" : "z";
    const int other = 3 - axis;
    findings.report(name,
                    "no crack can reach them, since no notch is cut into a {}-face; give "
                    "sections.{} instead, {}, or [[sections.line]], which cracks may cross anywhere",
                    axis_name, other == 1 ? "y" : "z", describe_ligaments(specimen, other));
    return;
  }
  for (std::size_t i = 0; i < positions.size(); ++i) {
    const std::string key = fmt::format("{}[{}]", name, i);
    if (findings.faulty(key)) continue;
    if (has_size && !(positions[i] > lower && positions[i] < upper)) {
      findings.report(key, "{} is not inside the {}; give a length between {} and {}", show(positions[i]),
                      extent_name(axis), lower == 0 ? "0" : show(lower), show(upper));
    } else if (i > 0 && positions[i] <= positions[i - 1]) {
      findings.report(key, "{} is not above {}, the length before it; give ascending lengths",
                      show(positions[i]), show(positions[i - 1]));
    } else if (has_notches && !parameters.draw && !can_arrive(specimen, axis, positions[i])) {
      findings.report(key, "no crack can reach {}; give a length in a notch's ligament: {}",
                      show(positions[i]), ligaments);
    }
  }
}

/// True if a part of the line, more than a point, lies inside the body's box.
bool meets_box(const SectionLine& line, const plane::Region& bounds) {
  double first = 0, last = 1;  // part of the line, as shares of its length
  for (std::size_t k = 0; k < 2; ++k) {
    const double start = line.from[k], way = line.to[k] - start;
    const double gap = touching * (bounds[k + 1].second - bounds[k + 1].first);
    const double lower = bounds[k + 1].first + gap, upper = bounds[k + 1].second - gap;
    if (way == 0 && !(start > lower && start < upper)) return false;
    if (way == 0) continue;
    const auto [enters, leaves] = std::minmax({(lower - start) / way, (upper - start) / way});
    first = std::max(first, enters);
    last = std::min(last, leaves);
  }
  return first < last;
}

void check_line(const SectionLine& line, const std::string& key, const plane::Specimen& specimen,
                Findings& findings) {
  if (findings.faulty(key)) return;
  const auto point = [](const std::array<double, 2>& p) {
    return fmt::format("[{}, {}]", show(p[0]), show(p[1]));
  };
  const auto end = [&](std::size_t axis, bool is_upper) {
    const auto [lower, upper] = bounds_of(specimen)[axis];
    const double at = is_upper ? upper : lower;
    return at == 0 ? "0" : show(at);
  };
  if (line.from == line.to) {
    findings.report(key + ".to", "{} is also the start of the line; give another point", point(line.to));
  } else if (size_is_known(findings) && !meets_box(line, bounds_of(specimen))) {
    findings.report(
        key,
        "the line from {} to {} does not pass through the body; give ends with y between {} and {} and "
        "z between {} and {}, or beyond",
        point(line.from), point(line.to), end(1, false), end(1, true), end(2, false), end(2, true));
  }
}

void check_plane(const SectionPlane& plane, const std::string& key, const plane::Specimen& specimen,
                 Findings& findings) {
  if (findings.faulty(key) || !size_is_known(findings)) return;
  const plane::Region bounds = bounds_of(specimen);
  int n_ahead = 0;
  for (unsigned corner = 0; corner < 8; ++corner) {
    double ahead = 0;
    for (unsigned axis = 0; axis < 3; ++axis) {
      const auto [lower, upper] = bounds[axis];
      ahead += plane.normal[axis] * (((corner >> axis) & 1U ? upper : lower) - plane.point[axis]);
    }
    n_ahead += ahead > 0 ? 1 : 0;
  }
  if (n_ahead == 0 || n_ahead == 8)
    findings.report(key + ".point", "the plane does not pass through the body; give a point in it");
}

void check_variation(Findings& findings, const Variation& variation) {
  const std::string table = "fracture.variation";
  const auto needs = [&](const char* key, const char* why, const char* example) {
    if (!findings.faulty(table + "." + key) && !findings.given(table + "." + key))
      findings.report(table + "." + key, "the key is missing, but {} requires it; give {} = {}", why, key,
                      example);
  };
  const auto refuses = [&](const char* key, const char* with) {
    if (findings.given(table + "." + key))
      findings.report(table + "." + key, "cannot be combined with distribution = \"{}\"; leave it out", with);
  };
  if (findings.faulty(table + ".distribution") || findings.faulty(table + ".correlation_length")) return;
  if (variation.distribution == Distribution::weibull) {
    needs("modulus", "distribution = \"weibull\"", "10");
    refuses("coefficient_of_variation", "weibull");
    if (variation.correlation_length == 0)
      needs("reference_volume", "\"weibull\" without correlation_length", "\"1 mm^3\"");
  } else {
    needs("coefficient_of_variation", "distribution = \"lognormal\"", "0.2");
    needs("correlation_length", "distribution = \"lognormal\"", "\"2 mm\"");
    refuses("modulus", "lognormal");
    refuses("reference_volume", "lognormal");
  }
}

/// True if each material has its own value of a key of [fracture].
bool given_by_materials(const Parameters& parameters, const std::string& key, const Findings& findings) {
  for (std::size_t i = 0; i < parameters.materials.size(); ++i) {
    const std::string path = material_key(parameters.materials, i) + ".";
    if (!findings.given(path + key) && !(key == "toughness" && findings.given(path + "fracture_toughness")))
      return false;
  }
  return true;
}

}  // namespace

void check_specimen(const Parameters& parameters, Findings& findings) {
  if (!size_is_known(findings) || !is_box(parameters.specimen)) return;
  const Vector& size = parameters.specimen.size;
  const auto& notches = parameters.specimen.notches;
  for (std::size_t i = 0; i < notches.size(); ++i) {
    if (findings.faulty(notch_key(i) + ".face")) continue;
    check_notch_in_body(notches[i], notch_key(i), size, findings);
  }
}

void check_stop(const Parameters& parameters, Findings& findings) {
  if (!parameters.ensemble.stop || findings.faulty("ensemble")) return;
  if (findings.given("specimen.solid"))
    findings.report("ensemble.stop", "judges the paths of cracks, which a solid has not; leave it out");
  else if (parameters.sections.size() == 0 && !findings.faulty("sections"))
    findings.report("ensemble.stop",
                    "judges the paths of cracks, but no section measures them; give sections.y, "
                    "sections.z or [[sections.line]]");
  const int least = parameters.ensemble.stop->min_samples;
  if (findings.given("ensemble.stop.min_samples") && least > parameters.ensemble.samples)
    findings.report("ensemble.stop.min_samples", "{} is more than ensemble.samples = {}; give fewer", least,
                    parameters.ensemble.samples);
}

void check_sections(const Parameters& parameters, Findings& findings) {
  const Sections& sections = parameters.sections;
  if (findings.given("specimen.solid")) {
    for (const char* const key : {"sections", "sections.line"})
      if (findings.given(key) && sections.size() > 0) {
        findings.report(key, "needs a plate, in whose plane cracks are followed; leave it out");
        return;
      }
    return;
  }
  if (sections.size() == 0 && sections.planes.empty() && !findings.faulty("sections")) {
    findings.report("sections",
                    "there are no cross-sections; give y, an array of lengths such as [\"7 mm\", "
                    "\"12.25 mm\"], or z, or a [[sections.line]] or [[sections.plane]]");
  }
  check_sections_along(1, sections.y, "sections.y", parameters, findings);
  check_sections_along(2, sections.z, "sections.z", parameters, findings);
  for (std::size_t i = 0; i < sections.lines.size(); ++i)
    check_line(sections.lines[i], fmt::format("sections.line[{}]", i), parameters.specimen, findings);
  for (std::size_t i = 0; i < sections.planes.size(); ++i)
    check_plane(sections.planes[i], fmt::format("sections.plane[{}]", i), parameters.specimen, findings);
}

std::vector<std::string> section_warnings(const Study& study) {
  const plane::Specimen& specimen = study.specimen;
  std::vector<std::string> warnings;
  const bool has_slots =
      std::ranges::any_of(specimen.notches, [](const plane::Notch& one) { return one.slot.has_value(); });
  if (is_box(specimen) || has_slots || specimen.solid || study.draw) return {};
  const auto look = [&](int axis, const char* name, const std::vector<double>& positions) {
    const std::string ligaments = describe_ligaments(specimen, axis);
    for (std::size_t i = 0; i < positions.size(); ++i)
      if (!ligaments.empty() && !can_arrive(specimen, axis, positions[i]))
        warnings.push_back(fmt::format(
            "no notch's crack can reach sections.{}[{}] = {}, only one that starts at a hole or elsewhere; "
            "notches have their ligaments {}",
            name, i, show(positions[i]), ligaments));
  };
  look(1, "y", study.sections.y);
  look(2, "z", study.sections.z);
  return warnings;
}

void complete_fracture(Parameters& parameters, Findings& findings) {
  if (parameters.fracture.fracture_toughness == 0) return;
  if (findings.given("fracture.toughness"))
    findings.report("fracture.fracture_toughness",
                    "is given together with toughness; give only one of the two");
  for (const char* const key : {"youngs_modulus", "poisson_ratio"})
    if (findings.faulty(material_key(parameters.materials, 0) + "." + key)) return;
  parameters.fracture.toughness = parameters.fracture_of(0).toughness;
}

void check_release(const std::string& table, Findings& findings) {
  if (findings.given(table + ".release_time") && findings.given(table + ".release_speed"))
    findings.report(table + ".release_speed",
                    "is given together with release_time; give only one of the two");
}

void check_fracture(const Parameters& parameters, Findings& findings) {
  check_release("fracture", findings);
  if (parameters.fracture.variation) check_variation(findings, *parameters.fracture.variation);
  const auto& size = parameters.specimen.size;
  if (const double largest = std::max({size[0], size[1], size[2]});
      size_is_known(findings) && parameters.fracture.length >= largest)
    findings.report("fracture.length",
                    "{} is as large as the body; give less than {}, such as a few spacings",
                    show(parameters.fracture.length), show(largest));
  if (findings.faulty("fracture.strength") || findings.faulty("fracture.toughness") ||
      findings.faulty("fracture.fracture_toughness"))
    return;
  const Fracture& fracture = parameters.fracture;
  const bool softens = fracture.softens();
  if (fracture.accumulation == Accumulation::step && !softens && parameters.fracture_of(0).toughness > 0 &&
      findings.given("fracture.impulse"))
    findings.note("fracture.impulse",
                  "has no effect: with accumulation = \"step\" the strengths that follow from the toughness "
                  "are those that break in one step");
  if (softens) {
    for (const auto& [key, is_missing] :
         {std::pair{"strength", fracture.strength == 0},
          {"toughness", fracture.toughness == 0 && fracture.fracture_toughness == 0}})
      if (is_missing && !given_by_materials(parameters, key, findings))
        findings.report(
            fmt::format("fracture.{}", key),
            "the key is missing, but release = \"softening\" requires it; give both strength, such as "
            "\"35 MPa\", and toughness, such as \"150 J/m^2\"");
    if (findings.given("fracture.length"))
      findings.report("fracture.length",
                      "cannot be combined with release = \"softening\", which has its own length; leave one "
                      "of the two out");
  } else {
    for (const char* const key : {"fracture.softening", "fracture.teeth"})
      if (findings.given(key))
        findings.report(key, "applies to release = \"softening\" only; leave it out, or give that release");
  }
  if (!softens && fracture.strength == 0 && fracture.toughness == 0 && fracture.fracture_toughness == 0 &&
      !given_by_materials(parameters, "strength", findings) &&
      !given_by_materials(parameters, "toughness", findings))
    findings.report(
        "fracture.toughness",
        "the key is missing; give a toughness such as \"93 J/m^2\", or fracture_toughness, such as \"0.6 MPa "
        "m^0.5\"; or a strength alone, with which the toughness depends on the spacing");
  Fracture by_means = parameters.fracture_of(0);
  by_means.nucleation = Nucleation::nodal_mean;
  if (findings.given("fracture.nucleation") && !by_means.nucleates_by_means())
    findings.note("fracture.nucleation",
                  "has no effect: it applies to fracture.strength, without length and softening");
  if (by_means.strength > 0 || fracture.length > 0) return;
  // At a smooth surface the threshold that follows from a toughness is that of the spacing.
  for (std::size_t i = 0; i < parameters.specimen.notches.size(); ++i)
    if (const auto& slot = parameters.specimen.notches[i].slot; slot && slot->end == plane::SlotEnd::round)
      findings.report("fracture.toughness",
                      "does not say when a crack starts at the round end of {}, a smooth surface; give "
                      "fracture.strength, too",
                      notch_key(i));
}

void check_time(const Parameters& parameters, Findings& findings) {
  const Time& time = parameters.time;
  if (parameters.damping && !findings.given("damping.mass") && !findings.given("damping.bulk"))
    findings.report("damping.mass", "the key is missing; give a rate such as \"500 1/s\", or bulk");
  if (time.engine == Engine::petsc && time.precision == Precision::mixed && findings.given("time.precision"))
    findings.report(
        "time.precision",
        "\"mixed\" requires engine = \"fixed-point\"; with \"petsc\" give \"double\", or leave it out");
  if (time.integrator != Integrator::verlet) {
    const char* const why =
        "requires time.integrator = \"verlet\": \"bilateral4\" has substeps backward in time, in which "
        "damping would add energy";
    if (parameters.damping && parameters.damping->mass > 0) findings.report("damping.mass", "{}", why);
    for (std::size_t i = 0; i < parameters.boundaries.size(); ++i)
      if (parameters.boundaries[i].kind == BoundaryKind::absorbing)
        findings.report(fmt::format("boundary[{}].absorbing", i), "{}", why);
  }
  if (time.step && time.mass_scaling > 0)
    findings.report(
        "time.mass_scaling",
        "finds a longer step, but time.step is given in line {}; leave one of the two out, or give "
        "time.step = \"auto\"",
        findings.line_of("time.step"));
  if (!time.step || findings.faulty("time.step") || findings.faulty("time.duration")) return;
  constexpr double max_steps = 1e9;
  const std::string duration = format_quantity(time.duration, time_dimension);
  const std::string step = format_quantity(*time.step, time_dimension);
  if (*time.step > time.duration) {
    findings.report("time.step", "{} exceeds the duration; give at most {}", step, duration);
  } else if (time.duration / *time.step > max_steps) {
    findings.report("time.step", "{} gives more than {:.0e} steps in {}; give a longer step", step, max_steps,
                    duration);
  }
}

}  // namespace crackle::input
