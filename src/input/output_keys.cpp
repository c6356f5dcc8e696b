// SPDX-License-Identifier: GPL-3.0-or-later
#include "consistency.h"
#include "schema.h"

#include "crackle/common/index.h"

#include <algorithm>
#include <array>
#include <set>
#include <string>
#include <vector>

namespace crackle::input {

namespace {

constexpr std::size_t max_name = 60;
/// Rows of a history in one dynamic phase.
constexpr double max_history_rows = 100'000;

Key name_key() {
  const std::string accepted = fmt::format(
      "a text of 1 to {} characters without \"/\" and control characters, such as \"gauge\"", max_name);
  return {"name",
          "text",
          required(),
          accepted,
          "of the probe, another one for each",
          [=](const Source& source, Parameters& parameters, std::size_t i) {
            const auto name = read_text(source, accepted);
            if (!name) return;
            if (name->size() > max_name) source.report("has {} characters; give {}", name->size(), accepted);
            // It becomes the name of a group in the sample files.
            const auto is_control = [](char c) { return static_cast<unsigned char>(c) < 0x20 || c == 0x7f; };
            if (std::ranges::any_of(*name, is_control) || name->find('/') != std::string::npos ||
                *name == "." || *name == "..")
              source.report("{} cannot be used; give {}", source.value.source, accepted);
            parameters.output.probes.at(i).name = *name;
          },
          [](Parameters& parameters, std::size_t i) { return parameters.output.probes.at(i).name; }};
}

Key place_key() {
  const std::string form = "three lengths, x, y and z, such as [\"2.5 mm\", \"12 mm\", \"40 mm\"]";
  return {"at",
          "length",
          required(),
          form,
          "place in the body",
          [=](const Source& source, Parameters& parameters, std::size_t i) {
            const auto elements = read_elements(source, 3, form);
            for (std::size_t axis = 0; elements && axis < 3; ++axis)
              if (const auto value = read_quantity((*elements)[axis], length_dimension, coordinate))
                parameters.output.probes.at(i).at[axis] = *value;
          },
          [](Parameters& parameters, std::size_t i) {
            const Vector& p = parameters.output.probes.at(i).at;
            return bracketed({show(p[0]), show(p[1]), show(p[2])});
          }};
}

/// Whether a place in the plane of the plate lies in the material, or within `slack` of it.
bool in_shape(const plane::Shape& shape, const plane::Point& p, double slack) {
  bool is_inside = true;
  double nearest = infinity;
  for (std::size_t k = 0; k < shape.loops.size(); ++k) {
    const plane::Loop& loop = shape.loops[k];
    is_inside = is_inside && plane::holds(loop.corners, p) == (k == 0);
    for (std::size_t i = 0; i < loop.size(); ++i)
      nearest = std::min(nearest, plane::distance(p, loop.from(i), loop.to(i)));
  }
  return is_inside || nearest <= slack;
}

/// Why a place is not in the body, or nothing.
std::optional<std::string> reason_outside(const Specimen& specimen, const Vector& p) {
  const Region bounds = bounds_of(specimen);
  double extent = 0;
  for (const auto& [lower, upper] : bounds) extent = std::max(extent, upper - lower);
  const double slack = 1e-9 * extent;
  for (std::size_t axis = 0; axis < 3; ++axis) {
    const auto [lower, upper] = bounds[axis];
    if (p[axis] < lower - slack || p[axis] > upper + slack)
      return fmt::format("{} = {} is outside the body; give a length from {} to {}", axis_names[axis],
                         show(p[axis]), show(lower), show(upper));
  }
  if (specimen.shape) {
    if (in_shape(*specimen.shape, {p[1], p[2]}, slack)) return {};
    return "the place is outside the body, or in a hole or a notch; give one in the material";
  }
  for (std::size_t i = 0; i < specimen.notches.size(); ++i) {
    const Region slot = slot_of(specimen.notches[i], specimen.size);
    bool is_inside = true;
    for (std::size_t axis = 1; axis < 3; ++axis)
      is_inside = is_inside && p[axis] > slot[axis].first + slack && p[axis] < slot[axis].second - slack;
    if (is_inside) return fmt::format("the place is in specimen.notch[{}]; give one in the material", i);
  }
  return {};
}

}  // namespace

Table output_table() {
  Key history = automatic_time_key(
      "history", [](Parameters & parameters, std::size_t) -> auto& { return parameters.output.history; },
      "0.5 us",
      "time between two rows of a sample's history in dynamic phases; \"auto\" is a 200th of the duration");
  // As if it had not been given.
  history.show = [show = history.show](Parameters& parameters, std::size_t i) -> std::optional<std::string> {
    if (!parameters.output.history) return {};
    return show(parameters, i);
  };
  return {
      "output",
      Occurrence::once,
      "what the sample files hold",
      {integer_key<int>(
           "frames", [](Parameters & parameters, std::size_t) -> auto& { return parameters.output.frames; },
           0, 100'000, by_default("11"), "pictures of the fields during the dynamic phase"),
       std::move(history)}};
}

Table probe_table() {
  return {"output.probe",
          Occurrence::many,
          "a place whose displacement, velocity and stress the history follows",
          {name_key(), place_key()},
          [](const Parameters& parameters) { return parameters.output.probes.size(); },
          [](Parameters& parameters) { parameters.output.probes.emplace_back(); }};
}

void check_output(const Parameters& parameters, Findings& findings) {
  const auto& [frames, history, probes] = parameters.output;
  if (history && !findings.faulty("output.history") && !findings.faulty("time.duration") &&
      parameters.time.duration / *history > max_history_rows)
    findings.report("output.history", "{} makes more than {:.0f} rows in {}; give a longer time",
                    format_quantity(*history, time_dimension), max_history_rows,
                    format_quantity(parameters.time.duration, time_dimension));
  std::set<std::string> names;
  for (std::size_t i = 0; i < probes.size(); ++i) {
    const std::string key = fmt::format("output.probe[{}]", i);
    if (!findings.faulty(key + ".name") && !names.insert(probes[i].name).second)
      findings.report(key + ".name", "another probe is called \"{}\"; give another name", probes[i].name);
    if (findings.faulty(key + ".at") || !size_is_known(findings) || findings.faulty("specimen")) continue;
    if (const auto reason = reason_outside(parameters.specimen, probes[i].at))
      findings.report(key + ".at", "{}", *reason);
  }
}

}  // namespace crackle::input
