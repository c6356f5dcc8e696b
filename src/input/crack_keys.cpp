// SPDX-License-Identifier: GPL-3.0-or-later
// [[specimen.crack]]: cracks that are there before any load.
#include "consistency.h"
#include "dimension.h"
#include "figures.h"
#include "schema.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>

namespace crackle::input {

namespace {

using plane::PreCrack;

/// Corners of a polygon this far out of its plane, relative to its size, are an error.
constexpr double out_of_plane = 1e-6;
/// Extent of a crack in spacings below which hardly any tetrahedron is opened by it.
constexpr double smallest_crack = 2;
constexpr int most_flaws = 100'000;

const std::string plane_point = "two lengths, y and z, such as [\"5 mm\", \"8 mm\"]";
const std::string space_point = "three lengths, x, y and z, such as [\"0 mm\", \"5 mm\", \"8 mm\"]";
const std::string polygon_form =
    "three points or more in one plane, x, y and z of each, such as [[\"0 mm\", \"5 mm\", \"8 mm\"], [\"2 "
    "mm\", \"5 mm\", "
    "\"8 mm\"], [\"2 mm\", \"9 mm\", \"8 mm\"]]";

PreCrack& crack(Parameters& parameters, std::size_t i) {
  return parameters.specimen.cracks.at(i);
}

bool has_ellipse(const Parameters& parameters, std::size_t i) {
  return parameters.specimen.cracks.at(i).semi_axes[0] > 0;
}

std::string show_space_point(const Vector& p) {
  return bracketed({show(p[0]), show(p[1]), show(p[2])});
}

Key end_key(const char* name, std::size_t end, const char* help) {
  return shown_if(lengths_key<plane::Point>(
                      name,
                      [=](Parameters& parameters, std::size_t i) -> plane::Point& {
                        auto& line = crack(parameters, i).line;
                        return (line ? *line : line.emplace())[end];
                      },
                      plane_point, coordinate, optional("required, or polygon or center"), help),
                  [](const Parameters& parameters, std::size_t i) {
                    return parameters.specimen.cracks.at(i).line.has_value();
                  });
}

Key crack_polygon_key() {
  return {"polygon",
          "length",
          optional("required, or from or center"),
          polygon_form,
          "corners in order, in space",
          [](const Source& source, Parameters& parameters, std::size_t i) {
            const auto elements = read_elements(source, 0, polygon_form);
            if (!elements) return;
            for (const Source& element : *elements) {
              const auto lengths = read_elements(element, 3, space_point);
              if (!lengths) return;
              Vector p{};
              for (std::size_t k = 0; k < 3; ++k) {
                const auto length = read_quantity((*lengths)[k], length_dimension, coordinate);
                if (!length) return;
                p[k] = *length;
              }
              crack(parameters, i).polygon.push_back(p);
            }
          },
          [](Parameters& parameters, std::size_t i) -> std::optional<std::string> {
            std::vector<std::string> corners;
            for (const Vector& p : crack(parameters, i).polygon) corners.push_back(show_space_point(p));
            if (corners.empty()) return {};
            return bracketed(corners);
          }};
}

/// True if the crack is given in one way, completely.
bool is_complete(const std::string& key, Findings& findings) {
  const auto given = [&](const char* name) { return findings.given(fmt::format("{}.{}", key, name)); };
  const int n_ways = (given("from") || given("to")) + given("polygon") +
                     (given("center") || given("semi_axes") || given("normal"));
  if (n_ways != 1) {
    findings.report(key, "{}; give either from and to, or polygon, or center, semi_axes and normal",
                    n_ways == 0 ? "the crack has no place" : "the crack is given in several ways");
    return false;
  }
  bool complete = true;
  const auto require = [&](std::initializer_list<std::pair<const char*, std::string>> names) {
    if (std::ranges::none_of(names, [&](const auto& name) { return given(name.first); })) return;
    for (const auto& [name, form] : names)
      if (!given(name)) {
        findings.report(fmt::format("{}.{}", key, name), "the key is missing; give {}", form);
        complete = false;
      }
  };
  require({{"from", plane_point}, {"to", plane_point}});
  require({{"center", space_point},
           {"semi_axes", "two lengths, such as [\"1 mm\", \"0.5 mm\"]"},
           {"normal", "three numbers, such as [0, 0, 1]"}});
  return complete;
}

/// Reports corners that do not make a polygon in one plane. @return whether they do
bool check_polygon(const std::vector<Vector>& corners, const std::string& key, Findings& findings) {
  if (corners.size() < 3) {
    findings.report(key, "{} points cannot enclose an area; give {}", corners.size(), polygon_form);
    return false;
  }
  Vector area{};
  double size = 0;
  for (std::size_t i = 1; i < corners.size(); ++i) {
    size = std::max(size, norm(corners[i] - corners[0]));
    if (i + 1 < corners.size()) area = area + cross(corners[i] - corners[0], corners[i + 1] - corners[0]);
  }
  if (!(norm(area) > out_of_plane * size * size)) {
    findings.report(key, "the corners enclose no area; give {}", polygon_form);
    return false;
  }
  const Vector normal = area / norm(area);
  for (std::size_t i = 0; i < corners.size(); ++i)
    if (const double off = std::abs(dot(normal, corners[i] - corners[0])); off > out_of_plane * size) {
      findings.report(fmt::format("{}[{}]", key, i), "is {:.3g} mm out of the plane of the others; give {}",
                      1e3 * off, polygon_form);
      return false;
    }
  // Seen along the axis closest to its normal.
  std::size_t axis = 0;
  for (std::size_t i = 1; i < 3; ++i)
    if (std::abs(normal[i]) > std::abs(normal[axis])) axis = i;
  plane::Polygon seen;
  for (const Vector& p : corners) seen.push_back({p[(axis + 1) % 3], p[(axis + 2) % 3]});
  if (plane::is_simple(seen)) return true;
  findings.report(key, "the polygon intersects itself; give its corners in order, each once");
  return false;
}

void read_direction(const Source& source, const std::string& form, Flaws& flaws) {
  const bool is_table = source.value.kind == ValueKind::table;
  if (source.value.kind == ValueKind::string && source.value.string == "isotropic") return;
  const Value* const given = is_table ? source.value.find("normal") : &source.value;
  if (given == nullptr || given->kind != ValueKind::array) {
    source.report("is {}; give {}", is_table ? "without a normal" : source.value.source, form);
    return;
  }
  Parameters scratch;
  Vector normal{};
  direction_key(
      "normal", [&](Parameters&, std::size_t) -> Vector& { return normal; }, required(), "")
      .read({*given, is_table ? source.key + ".normal" : source.key, source.context}, scratch, 0);
  flaws.normal = normal;
  for (const Member& member : source.value.members) {
    const Source value{member.value, source.key + "." + member.name, source.context};
    if (member.name == "spread") {
      if (const auto spread = read_quantity(value, angle_dimension, {0, std::numbers::pi}))
        flaws.spread = *spread;
    } else if (member.name != "normal") {
      value.report("unknown key; give normal and spread");
    }
  }
}

}  // namespace

Table crack_table() {
  return {
      "specimen.crack",
      Occurrence::many,
      "a crack that is there before any load, closed: through the thickness, or a polygon or an ellipse "
      "in space; parts outside the body do not count",
      {end_key("from", 0, "an end of a crack through the thickness"), end_key("to", 1, "the other end"),
       crack_polygon_key(),
       shown_if(lengths_key<Vector>(
                    "center", [](Parameters & parameters, std::size_t i) -> auto& {
                      return crack(parameters, i).center;
                    },
                    space_point, coordinate, optional("required, or from or polygon"), "of an ellipse"),
                has_ellipse),
       shown_if(lengths_key<plane::Point>(
                    "semi_axes", [](Parameters & parameters, std::size_t i) -> auto& {
                      return crack(parameters, i).semi_axes;
                    },
                    "two lengths, such as [\"1 mm\", \"0.5 mm\"]", positive_length,
                    optional("required with center"),
                    "of an ellipse; the first is along that coordinate axis which is most perpendicular to "
                    "the normal, the first of several"),
                has_ellipse),
       shown_if(direction_key(
                    "normal", [](Parameters & parameters, std::size_t i) -> auto& {
                      return crack(parameters, i).normal;
                    },
                    optional("required with center"), "across an ellipse, of any length"),
                has_ellipse)},
      [](const Parameters& parameters) { return parameters.specimen.cracks.size(); },
      [](Parameters& parameters) { parameters.specimen.cracks.emplace_back(); }};
}

Table flaws_table() {
  const auto flaws = [](Parameters& parameters, std::size_t i) -> Flaws& { return parameters.flaws.at(i); };
  const std::string radius_form =
      "a length, such as \"0.5 mm\", or a distribution as in [[random]], such as { distribution = "
      "\"weibull\", shape = 3, "
      "scale = \"0.5 mm\" }";
  const std::string direction_form =
      "\"isotropic\"; a normal, such as [0, 0, 1]; or { normal = [0, 0, 1], spread = \"20 degree\" }";
  Key number{"number",
             "integer",
             optional("required, or density"),
             accepted_integer(1, most_flaws),
             "of flaws in each sample",
             [=](const Source& source, Parameters& parameters, std::size_t i) {
               if (const auto value = read_integer(source, 1, most_flaws))
                 flaws(parameters, i).number = static_cast<int>(*value);
             },
             [=](Parameters& parameters, std::size_t i) -> std::optional<std::string> {
               if (const auto& some = flaws(parameters, i).number) return fmt::format("{}", *some);
               return {};
             }};
  Key density = hidden_at_zero(
      quantity_key(
          "density",
          [=](Parameters & parameters, std::size_t i) -> auto& { return flaws(parameters, i).density; },
          number_density_dimension, {0, 1e18, true}, optional("required, or number"),
          "mean number per volume, of a Poisson process"),
      [=](Parameters & parameters, std::size_t i) -> auto& { return flaws(parameters, i).density; });
  Key size{"size",
           "length",
           required(),
           radius_form,
           "radius of the flaws, which are circles",
           [=](const Source& source, Parameters& parameters, std::size_t i) {
             Flaws& some = flaws(parameters, i);
             some.radii.key = "size";
             some.radii.unit = length_dimension.si_unit;
             if (source.value.kind == ValueKind::table)
               read_distribution(source, some.radii);
             else if (const auto radius = read_quantity(source, length_dimension, positive_length))
               some.radius = *radius;
           },
           [=](Parameters& parameters, std::size_t i) -> std::optional<std::string> {
             const Flaws& some = flaws(parameters, i);
             return some.radius > 0 ? show(some.radius) : show_distribution(some.radii);
           }};
  Key direction{"direction",
                "number",
                by_default("\"isotropic\""),
                direction_form,
                "of their normals; spread is the standard deviation of the angle from the given one",
                [=](const Source& source, Parameters& parameters, std::size_t i) {
                  read_direction(source, direction_form, flaws(parameters, i));
                },
                [=](Parameters& parameters, std::size_t i) -> std::optional<std::string> {
                  const Flaws& some = flaws(parameters, i);
                  if (!some.normal) return "isotropic";
                  std::vector<std::string> components;
                  for (const double component : *some.normal) components.push_back(format_number(component));
                  const std::string normal = bracketed(components);
                  if (some.spread == 0) return normal;
                  return fmt::format("{{normal = {}, spread = {}}}", normal,
                                     format_quantity(some.spread, angle_dimension));
                }};
  std::vector<Key> keys{std::move(number), std::move(density), std::move(size), std::move(direction)};
  for (std::size_t axis = 0; axis < 3; ++axis)
    keys.push_back(range_key(
        fmt::format("region.{}", axis_names[axis]),
        [=](Parameters & parameters, std::size_t i) -> auto& { return flaws(parameters, i).region[axis]; },
        {"2 mm", "8 mm"}, "whole body", "where their middles are, uniformly"));
  return {"random.flaws",
          Occurrence::many,
          "round pre-cracks, other ones in each sample",
          std::move(keys),
          [](const Parameters& parameters) { return parameters.flaws.size(); },
          [](Parameters& parameters) { parameters.flaws.emplace_back(); }};
}

namespace {

void check_flaws(const Parameters& parameters, const plane::Region& bounds, Findings& findings) {
  for (std::size_t i = 0; i < parameters.flaws.size(); ++i) {
    const Flaws& flaws = parameters.flaws[i];
    const std::string key = fmt::format("random.flaws[{}]", i);
    if (findings.given(key + ".number") == findings.given(key + ".density"))
      findings.report(key, "{}; give number or density, the mean number per volume",
                      flaws.number ? "number and density are both given" : "the number of flaws is missing");
    if (!findings.faulty(key + ".size") && findings.given(key + ".size") && flaws.radius == 0) {
      if (has_own_mean(flaws.radii))
        findings.report(key + ".size.mean", "the key is missing; give a length such as \"1 mm\"");
      else
        check_distribution(flaws.radii, key + ".size", findings);
    }
    double number = flaws.density;
    for (std::size_t axis = 0; axis < 3; ++axis)
      number *= std::max(0.0, std::min(bounds[axis].second, flaws.region[axis].second) -
                                  std::max(bounds[axis].first, flaws.region[axis].first));
    if (number > most_flaws)
      findings.report(key + ".density", "gives some {:.3g} flaws; give a density with at most {}", number,
                      most_flaws);
    for (std::size_t axis = 0; axis < 3; ++axis) {
      const auto& [lower, upper] = flaws.region[axis];
      const std::string region = fmt::format("{}.region.{}", key, axis_names[axis]);
      if (!findings.faulty(region) && (lower >= bounds[axis].second || upper <= bounds[axis].first))
        findings.report(region, "lies outside the body; give lengths between {} and {}",
                        show(bounds[axis].first), show(bounds[axis].second));
    }
    if (has_spacing(parameters, findings) && flaws.radius > 0 &&
        2 * flaws.radius < smallest_crack * parameters.mesh.finest_spacing())
      findings.report(key + ".size",
                      "flaws of {} are too small for the mesh; give at least {}, or a smaller mesh.spacing",
                      show(flaws.radius), show(smallest_crack / 2 * parameters.mesh.finest_spacing()));
  }
}

}  // namespace

void check_cracks(const Parameters& parameters, Findings& findings) {
  const plane::Region bounds = size_is_known(findings) ? bounds_of(parameters.specimen) : plane::everywhere;
  check_flaws(parameters, bounds, findings);
  for (std::size_t i = 0; i < parameters.specimen.cracks.size(); ++i) {
    const PreCrack& crack = parameters.specimen.cracks[i];
    const std::string key = fmt::format("specimen.crack[{}]", i);
    if (findings.faulty(key) || !is_complete(key, findings)) continue;
    std::vector<Vector> points = crack.polygon;  // that enclose it
    double extent = infinity;                    // the smaller one
    if (crack.line && parameters.specimen.solid) {
      findings.report(key + ".from",
                      "needs a plate, through whose thickness the crack runs; give polygon, or center, "
                      "semi_axes and normal");
      continue;
    }
    if (crack.line) {
      for (const plane::Point& p : *crack.line)
        for (const double x : {bounds[0].first, bounds[0].second}) points.push_back({x, p[0], p[1]});
      const plane::Point along{(*crack.line)[1][0] - (*crack.line)[0][0],
                               (*crack.line)[1][1] - (*crack.line)[0][1]};
      extent = plane::norm(along);
    } else if (!crack.polygon.empty()) {
      if (!check_polygon(crack.polygon, key + ".polygon", findings)) continue;
      extent = 0;
      for (const Vector& p : points)
        for (const Vector& q : points) extent = std::max(extent, norm(p - q));
    } else {
      const auto& [a, b] = crack.semi_axes;
      extent = 2 * std::min(a, b);
      const double most = std::max(a, b), length = norm(crack.normal);
      Vector reach{};
      for (std::size_t k = 0; k < 3; ++k)
        reach[k] = most * std::sqrt(std::max(0.0, 1 - std::pow(crack.normal[k] / length, 2)));
      points = {crack.center - reach, crack.center + reach};
    }
    for (std::size_t k = 0; k < 3; ++k) {
      const auto [low, high] = std::ranges::minmax(points, {}, [&](const Vector& p) { return p[k]; });
      if (high[k] > bounds[k].first && low[k] < bounds[k].second) continue;
      if (low[k] < high[k] || low[k] < bounds[k].first || low[k] > bounds[k].second) {
        findings.report(key, "lies outside the body; give {} between {} and {}", "xyz"[k],
                        show(bounds[k].first), show(bounds[k].second));
        break;
      }
    }
    const double least = smallest_crack * parameters.mesh.finest_spacing();
    if (has_spacing(parameters, findings) && extent < least)
      findings.report(key, "its extent of {} is too small for the mesh; give at least {}, or a smaller {}",
                      show(extent), show(least),
                      findings.given("mesh.notch_spacing") ? "mesh.notch_spacing" : "mesh.spacing");
  }
}

}  // namespace crackle::input
