// SPDX-License-Identifier: GPL-3.0-or-later
#include "schema.h"

#include "common/printable.h"
#include "common/quantity_text.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <fstream>
#include <iterator>
#include <memory>
#include <numbers>
#include <sstream>
#include <system_error>

namespace crackle::input {

namespace {

constexpr std::size_t max_corners = 1000;  ///< of a polygon; limits the checks to less than a second

const std::string point_form = "two lengths, y and z, such as [\"5 mm\", \"8 mm\"]";
const std::string polygon_form =
    "three points or more, y and z of each, such as [[\"0 mm\", \"0 mm\"], [\"20 mm\", \"0 mm\"], [\"10 "
    "mm\", \"30 "
    "mm\"]]";

const std::string solid_form = std::string(solid::accepted_files) + ", such as \"part.stl\"";

std::string show_point(const plane::Point& p) {
  return bracketed({show(p[0]), show(p[1])});
}

std::string show_polygon(const plane::Polygon& polygon) {
  std::vector<std::string> corners;
  for (const plane::Point& p : polygon) corners.push_back(show_point(p));
  return bracketed(corners);
}

std::optional<plane::Point> read_pair(const Source& source, const std::string& form, const Range& range) {
  const auto elements = read_elements(source, 2, form);
  if (!elements) return {};
  const auto first = read_quantity((*elements)[0], length_dimension, range);
  const auto second = read_quantity((*elements)[1], length_dimension, range);
  if (!first || !second) return {};
  return plane::Point{*first, *second};
}

/// At least three points.
std::optional<plane::Polygon> checked_polygon(const Source& source, plane::Polygon polygon) {
  if (polygon.size() < 3)
    return source.report("{} cannot enclose an area; give {}", count_text(polygon.size(), "point"),
                         polygon_form);
  if (polygon.size() > max_corners)
    return source.report("has {} points; give at most {}", polygon.size(), max_corners);
  return polygon;
}

std::optional<plane::Polygon> read_polygon(const Source& source) {
  const auto elements = read_elements(source, 0, polygon_form);
  if (!elements) return {};
  plane::Polygon polygon;
  bool is_sound = true;
  for (const Source& element : *elements) {
    const auto p = read_pair(element, point_form, coordinate);
    is_sound = is_sound && p;
    polygon.push_back(p.value_or(plane::Point{}));
  }
  if (!is_sound) return {};
  return checked_polygon(source, std::move(polygon));
}

/// Reads points from a text file: two numbers "y z" in millimetres per line; # begins a comment.
std::optional<plane::Polygon> read_polygon_file(const Source& source) {
  const std::filesystem::path file = source.context.folder / source.value.string;
  const std::string name = shortened(file.string(), 200);
  std::error_code error;
  if (!std::filesystem::is_regular_file(file, error))
    return source.report(
        "there is no file \"{}\"; give {}; or the name of a file with two numbers \"y z\" in millimetres on "
        "each line; or \"circle\"",
        name, polygon_form);
  std::ifstream stream(file);
  plane::Polygon polygon;
  std::string text;
  for (int line = 1; std::getline(stream, text); ++line) {
    if (line == 1) text = without_mark(text);
    text = text.substr(0, text.find('#'));
    std::ranges::replace(text, ',', ' ');
    if (trimmed(text).empty() || text == "\r") continue;
    std::istringstream numbers(text);
    numbers.imbue(std::locale::classic());
    plane::Point p{};
    std::string rest;
    if (!(numbers >> p[0] >> p[1]) || (numbers >> rest) || !std::isfinite(p[0]) || !std::isfinite(p[1]))
      return source.report("{}:{}: not a point; give two numbers \"y z\" in millimetres", name, line);
    for (double& coordinate_of : p) coordinate_of *= 1e-3;
    if (!coordinate.contains(p[0]) || !coordinate.contains(p[1]))
      return source.report("{}:{}: is out of range; give {}", name, line,
                           accepted(length_dimension, coordinate));
    polygon.push_back(p);
    if (polygon.size() > max_corners) break;
  }
  if (stream.bad() || (polygon.empty() && !stream.eof()))
    return source.report("the file \"{}\" cannot be read; give the name of a readable file", name);
  return checked_polygon(source, std::move(polygon));
}

plane::Outline& outline(Parameters& parameters) {
  if (!parameters.specimen.outline) parameters.specimen.outline.emplace();
  return *parameters.specimen.outline;
}

bool has_outline(const Parameters& parameters, std::size_t) {
  return parameters.specimen.outline.has_value();
}

bool has_solid(const Parameters& parameters, std::size_t) {
  return !parameters.specimen.solid_file.empty();
}

Key size_key() {
  return shown_if(
      lengths_key<Vector>(
          "size", [](Parameters & parameters, std::size_t) -> auto& { return parameters.specimen.size; },
          "three lengths, such as [\"5 mm\", \"24.5 mm\", \"140 mm\"]", positive_length,
          required_unless({"outline", "solid"}), "thickness (x), width (y) and length (z) of the box"),
      [](const Parameters& parameters, std::size_t i) {
        return !has_outline(parameters, i) && !has_solid(parameters, i);
      });
}

/// The whole content of a file, or nothing.
std::optional<std::string> content_of(const std::filesystem::path& file) {
  std::error_code error;
  std::ifstream stream(file, std::ios::binary);
  if (!std::filesystem::is_regular_file(file, error) || !stream) return {};
  std::string content(std::istreambuf_iterator<char>(stream), {});
  return stream.bad() ? std::nullopt : std::optional(std::move(content));
}

Key solid_key() {
  return {"solid",
          "file name",
          optional("required, or size or outline"),
          solid_form,
          "a closed surface (.stl, .obj, .off, .ply), or a mesh of Gmsh (.msh) or VTK (.vtk) in ASCII; faces "
          "have "
          "the names of the file's groups, else face-0, face-1 and so on, whose facets meet at less than 20 "
          "degrees; planes at an end of the body also x-min, x-max and so on",
          [](const Source& source, Parameters& parameters, std::size_t) {
            const auto name = read_text(source, solid_form);
            if (!name) return;
            parameters.specimen.solid_file = *name;
            parameters.specimen.solid = source.context.files.known_solid;
            if (parameters.specimen.solid) return;
            const Value* const unit = find_path(*source.context.root, "specimen.unit");
            if (unit == nullptr || unit->kind != ValueKind::string) return;  // reported there
            const Quantity one = source.context.units.read("1 " + unit->string, length_dimension);
            if (one.error != QuantityError::none || !positive_length.contains(one.value)) {
              Source{*unit, "specimen.unit", source.context}.report(
                  "\"{}\" is no unit of length; give one such as \"mm\"", shortened(unit->string));
              return;
            }
            const auto& given = source.context.files.solid;
            const std::filesystem::path file = given.empty() ? source.context.folder / *name : given;
            const std::string shown = shortened(file.string(), 200);
            auto content = content_of(file);
            if (!content) {
              source.report("there is no file \"{}\" that can be read; give {}", shown, solid_form);
              return;
            }
            std::string extension = file.extension().string();
            std::ranges::transform(extension, extension.begin(), [](char c) {
              return c >= 'A' && c <= 'Z' ? static_cast<char>(c - 'A' + 'a') : c;
            });
            try {
              parameters.specimen.solid = std::make_shared<const solid::Solid>(
                  solid::read_solid(std::move(*content), extension, unit->string, one.value));
            } catch (const std::exception& error) {
              source.report("\"{}\" {}", shown, shortened(error.what(), 500));
            }
          },
          [](Parameters& parameters, std::size_t i) -> std::optional<std::string> {
            if (!has_solid(parameters, i)) return {};
            return parameters.specimen.solid_file;
          }};
}

Key unit_key() {
  return {"unit",
          "word",
          optional("required with solid"),
          "a unit of length, such as \"mm\"",
          "of the coordinates in the file of solid",
          [](const Source& source, Parameters&, std::size_t) {
            read_text(source, "a unit of length, such as \"mm\"");
          },
          [](Parameters& parameters, std::size_t) -> std::optional<std::string> {
            if (!parameters.specimen.solid) return {};
            return parameters.specimen.solid->unit;
          }};
}

Key thickness_key() {
  return shown_if(quantity_key(
                      "thickness", [](Parameters & parameters, std::size_t) -> auto& {
                        return parameters.specimen.size[0];
                      },
                      length_dimension, positive_length, optional("required with outline"), "along x"),
                  has_outline);
}

Key outline_key() {
  return {"outline",
          "length",
          optional("required, or size"),
          polygon_form + "; a text file with \"y z\" in millimetres on each line; or \"circle\"",
          "in the plane of the plate; a circle has its centre at y = z = radius",
          [](const Source& source, Parameters& parameters, std::size_t) {
            plane::Outline& result = outline(parameters);
            if (source.value.kind != ValueKind::string) {
              result.polygon = read_polygon(source).value_or(plane::Polygon{});
            } else if (source.value.string != "circle") {
              result.polygon = read_polygon_file(source).value_or(plane::Polygon{});
            }
          },
          [](Parameters& parameters, std::size_t) -> std::optional<std::string> {
            if (!parameters.specimen.outline) return {};
            const plane::Polygon& polygon = parameters.specimen.outline->polygon;
            return polygon.empty() ? "circle" : show_polygon(polygon);
          }};
}

Key outline_radius_key() {
  return shown_if(
      quantity_key(
          "radius", [](Parameters & parameters, std::size_t) -> auto& { return outline(parameters).radius; },
          length_dimension, positive_length, optional("required with \"circle\""), "of outline = \"circle\""),
      [](const Parameters& parameters, std::size_t) {
        return parameters.specimen.outline && parameters.specimen.outline->radius != 0;
      });
}

/// Where the keys of a figure find it: holes, and regions with a shape other than a box.
struct FigureAccess {
  std::function<plane::Hole&(Parameters&, std::size_t)> make;
  std::function<const plane::Hole*(const Parameters&, std::size_t)> find;  ///< null if there is none
};

/// Text of a key for a figure that is there.
template <class Show>
auto shown_of(const FigureAccess& figure, Show show) {
  return [=](Parameters& parameters, std::size_t i) -> std::optional<std::string> {
    const plane::Hole* const some = figure.find(parameters, i);
    if (some == nullptr) return {};
    return show(*some);
  };
}

Key center_key(const FigureAccess& figure) {
  return shown_if(
      lengths_key<plane::Point>(
          "center",
          [=](Parameters & parameters, std::size_t i) -> auto& { return figure.make(parameters, i).center; },
          point_form, coordinate, optional("required with radius and semi_axes"), "centre"),
      [=](const Parameters& parameters, std::size_t i) {
        const plane::Hole* const some = figure.find(parameters, i);
        return some != nullptr && some->polygon.empty();
      });
}

Key radius_key(const FigureAccess& figure) {
  return {"radius",
          "length",
          optional("required for a circle"),
          quantity_form(length_dimension),
          "radius",
          [=](const Source& source, Parameters& parameters, std::size_t i) {
            if (const auto value = read_quantity(source, length_dimension, positive_length))
              figure.make(parameters, i).semi_axes = {*value, *value};
          },
          shown_of(figure, [](const plane::Hole& some) -> std::optional<std::string> {
            const auto& [a, b] = some.semi_axes;
            if (!some.polygon.empty() || a != b) return {};
            return show(a);
          })};
}

Key semi_axes_key(const FigureAccess& figure) {
  return shown_if(lengths_key<plane::Point>(
                      "semi_axes",
                      [=](Parameters & parameters, std::size_t i) -> auto& {
                        return figure.make(parameters, i).semi_axes;
                      },
                      "two lengths, such as [\"4 mm\", \"2 mm\"]", positive_length,
                      optional("required for an ellipse"), "semi-axes"),
                  [=](const Parameters& parameters, std::size_t i) {
                    const plane::Hole* const some = figure.find(parameters, i);
                    return some != nullptr && some->polygon.empty() &&
                           some->semi_axes[0] != some->semi_axes[1];
                  });
}

Key angle_key(const FigureAccess& figure) {
  const Range range{-2 * std::numbers::pi, 2 * std::numbers::pi};
  return {"angle",
          "angle",
          optional("0"),
          "an angle such as \"30 degree\" or \"0.5 rad\"",
          "of the first semi-axis, from y towards z",
          [=](const Source& source, Parameters& parameters, std::size_t i) {
            if (const auto value = read_quantity(source, angle_dimension, range))
              figure.make(parameters, i).angle = *value;
          },
          shown_of(figure, [](const plane::Hole& some) -> std::optional<std::string> {
            if (some.angle == 0 || some.semi_axes[0] == some.semi_axes[1]) return {};
            return format_quantity(some.angle, angle_dimension);
          })};
}

Key polygon_key(const FigureAccess& figure, std::string help) {
  return {"polygon",
          "length",
          optional("required for a polygon"),
          polygon_form,
          std::move(help),
          [=](const Source& source, Parameters& parameters, std::size_t i) {
            plane::Hole& some = figure.make(parameters, i);
            if (const auto polygon = read_polygon(source)) some.polygon = *polygon;
          },
          shown_of(figure, [](const plane::Hole& some) -> std::optional<std::string> {
            if (some.polygon.empty()) return {};
            return show_polygon(some.polygon);
          })};
}

std::vector<Key> figure_keys(const FigureAccess& figure, std::string corners_of) {
  return {center_key(figure), radius_key(figure), semi_axes_key(figure), angle_key(figure),
          polygon_key(figure, std::move(corners_of))};
}

template <class T>
Access<T> notch(T plane::Notch::*member) {
  return
      [=](Parameters& parameters, std::size_t i) -> T& { return parameters.specimen.notches.at(i).*member; };
}

plane::Slot& slot(Parameters& parameters, std::size_t i) {
  plane::Notch& some = parameters.specimen.notches.at(i);
  if (!some.slot) some.slot.emplace();
  return *some.slot;
}

/// A key of slots in a face, not shown for other slots.
Key of_face(Key key) {
  return shown_if(std::move(key), [](const Parameters& parameters, std::size_t i) {
    return !parameters.specimen.notches.at(i).slot;
  });
}

Key slot_point_key(const char* name, plane::Point plane::Slot::*member, const char* help) {
  return shown_if(
      lengths_key<plane::Point>(
          name, [=](Parameters & parameters, std::size_t i) -> auto& { return slot(parameters, i).*member; },
          point_form, coordinate, optional("required, or face"), help),
      [](const Parameters& parameters, std::size_t i) {
        return parameters.specimen.notches.at(i).slot.has_value();
      });
}

Key slot_end_key() {
  const std::vector<std::string> words{"square", "round"};
  return {"end",
          "word",
          optional("\"square\""),
          accepted_choice(words),
          "inside the body; a round one also stops at the point",
          [=](const Source& source, Parameters& parameters, std::size_t i) {
            if (const auto choice = read_choice(source, words))
              slot(parameters, i).end = *choice == 0 ? plane::SlotEnd::square : plane::SlotEnd::round;
          },
          [=](Parameters& parameters, std::size_t i) -> std::optional<std::string> {
            const auto& some = parameters.specimen.notches.at(i).slot;
            if (!some) return {};
            return words[some->end == plane::SlotEnd::square ? 0 : 1];
          }};
}

Table hole_table() {
  const FigureAccess figure{
      [](Parameters& parameters, std::size_t i) -> plane::Hole& { return parameters.specimen.holes.at(i); },
      [](const Parameters& parameters, std::size_t i) { return &parameters.specimen.holes.at(i); }};
  return {"specimen.hole",
          Occurrence::many,
          "a hole through the thickness: a circle, an ellipse or a polygon",
          figure_keys(figure, "corners"),
          [](const Parameters& parameters) { return parameters.specimen.holes.size(); },
          [](Parameters& parameters) { parameters.specimen.holes.emplace_back(); }};
}

Table material_region_table() {
  const auto region = [](Parameters& parameters, std::size_t i) -> plane::MaterialRegion& {
    return parameters.specimen.regions.at(i);
  };
  const FigureAccess figure{[=](Parameters& parameters, std::size_t i) -> plane::Hole& {
                              auto& shape = region(parameters, i).shape;
                              return shape ? *shape : shape.emplace();
                            },
                            [](const Parameters& parameters, std::size_t i) {
                              const auto& shape = parameters.specimen.regions.at(i).shape;
                              return shape ? &*shape : nullptr;
                            }};
  const auto range = [&](std::size_t axis, const char* name) {
    return range_key(
        name,
        [=](Parameters & parameters, std::size_t i) -> auto& { return region(parameters, i).box[axis]; },
        {"0 mm", "2 mm"}, "whole body", "extent of a box; x also of other shapes");
  };
  std::vector<Key> keys{
      text_key(
          "material",
          [=](Parameters& parameters, std::size_t i) -> std::string& {
            return region(parameters, i).material;
          },
          required(), "the name of a [[material]], such as \"coating\"", "that fills the region"),
      range(0, "x"), range(1, "y"), range(2, "z")};
  for (Key& key : figure_keys(figure, "corners")) keys.push_back(std::move(key));
  return {"specimen.region",
          Occurrence::many,
          "a part of another material than the first; where several overlap, the last counts",
          std::move(keys),
          [](const Parameters& parameters) { return parameters.specimen.regions.size(); },
          [](Parameters& parameters) { parameters.specimen.regions.emplace_back(); }};
}

Table notch_table() {
  const Requirement unless_from = required_unless({"from"});
  return {"specimen.notch",
          Occurrence::many,
          "a slot through the thickness: cut into a face, or between two points",
          {of_face(choice_key<plane::Face>("face", notch(&plane::Notch::face), faces_from(plane::Face::y_min),
                                           unless_from, "where the slot is cut in")),
           of_face(quantity_key("at", notch(&plane::Notch::at), with_example(length_dimension, "65 mm"),
                                coordinate, unless_from,
                                "mid-plane of the slot, along the face's other in-plane axis")),
           of_face(quantity_key("depth", notch(&plane::Notch::depth), with_example(length_dimension, "6 mm"),
                                positive_length, unless_from, "from the face to the tip")),
           quantity_key("height", notch(&plane::Notch::height), with_example(length_dimension, "0.6 mm"),
                        positive_length, required(), "opening of the slot"),
           slot_point_key("from", &plane::Slot::from,
                          "start of the centre line; open if on the surface or outside the body"),
           slot_point_key("to", &plane::Slot::to, "its end"), slot_end_key()},
          [](const Parameters& parameters) { return parameters.specimen.notches.size(); },
          [](Parameters& parameters) { parameters.specimen.notches.emplace_back(); }};
}

}  // namespace

std::vector<Table> specimen_tables() {
  return {{"specimen",
           Occurrence::once,
           "the body: a box or an extruded outline, with holes and notches; or any solid",
           {size_key(), thickness_key(), outline_key(), outline_radius_key(),
            solid_key().that_affects(Affects::run), unit_key()}},
          hole_table(),
          notch_table(),
          crack_table(),
          material_region_table()};
}

}  // namespace crackle::input
