// SPDX-License-Identifier: GPL-3.0-or-later
#include "experiment_keys.h"

#include "crackle/common/regular_file.h"
#include "input/dimension.h"
#include "input/schema.h"

#include <fmt/format.h>

#include <functional>
#include <numbers>
#include <utility>

namespace crackle::experiment {

namespace {

using input::BasicKey;
using input::BasicTable;
using input::Dimension;
using input::Occurrence;
using input::Range;
using input::Requirement;
using input::Source;

constexpr Range error_range{0, 1e3};
constexpr Range load_range{0, 1e12};
constexpr Range time_range{0, 1e3};
constexpr Range pixels{-1e6, 1e6};
constexpr const char* accepted_picture = "the name of a PNG or JPEG file";

const char* const place_form = "two lengths, y and z, such as [\"12.25 mm\", \"70 mm\"]";
const char* const pixel_form = "two numbers of pixels, from the left and from the top, such as [120, 480]";

const Dimension& force_dimension() {
  return input::value_dimension(input::BoundaryKind::force);
}

const Dimension& area_dimension() {
  static const Dimension area{"an area", "m^2", "2.5 mm^2", 0, {{"m^2", 1}, {"mm^2", 1e-6}}};
  return area;
}

/// A key whose value is read by `read`, which may report an error and return nothing, and stored by `store`.
template <class Target, class Read, class Store>
BasicKey<Target> key(std::string name, std::string dimension, Requirement requirement, std::string accepted,
                     std::string help, Read read, Store store) {
  return {std::move(name),
          std::move(dimension),
          std::move(requirement),
          std::move(accepted),
          std::move(help),
          [read, store](const Source& source, Target& target, std::size_t) {
            if (auto value = read(source)) store(target, std::move(*value));
          },
          {}};
}

template <class Target, class Store>
BasicKey<Target> quantity(std::string name, const Dimension& dimension, Range range, Requirement requirement,
                          std::string help, Store store) {
  return key<Target>(
      std::move(name), dimension.name, std::move(requirement), accepted(dimension, range), std::move(help),
      [dimension, range](const Source& source) { return read_quantity(source, dimension, range); }, store);
}

template <class Target, class Store>
BasicKey<Target> flag(std::string name, std::string unset, std::string help, Store store) {
  return key<Target>(
      std::move(name), "boolean", input::optional(std::move(unset)), "true", std::move(help),
      [](const Source& source) -> std::optional<bool> {
        if (source.value.kind == input::ValueKind::boolean) return source.value.boolean;
        return source.report("{} is {}; give true or false, without quotes", source.value.source,
                             describe(source.value.kind));
      },
      store);
}

template <class Target, class Store>
BasicKey<Target> place(std::string name, Requirement requirement, std::string help, Store store) {
  return key<Target>(
      std::move(name), "lengths", std::move(requirement), place_form, std::move(help),
      [](const Source& source) -> std::optional<plane::Point> {
        const auto elements = read_elements(source, 2, place_form);
        if (!elements) return {};
        const auto y = read_quantity((*elements)[0], input::length_dimension, input::coordinate);
        const auto z = read_quantity((*elements)[1], input::length_dimension, input::coordinate);
        if (!y || !z) return {};
        return plane::Point{*y, *z};
      },
      store);
}

/// The name of a CSV file.
BasicKey<Draft> file(std::string name, const std::string& header, std::string unset, std::string help,
                     std::string Draft::*member) {
  const std::string accepted =
      fmt::format("the name of a CSV file with the header {}, such as \"{}.csv\"", header, name);
  return key<Draft>(
      std::move(name), "file name", input::optional(std::move(unset)), accepted, std::move(help),
      [accepted](const Source& source) { return read_text(source, accepted); },
      [member](Draft& draft, std::string value) { draft.*member = std::move(value); });
}

BasicKey<Draft> load_error_key() {
  return quantity<Draft>("load_error", force_dimension(), {0, 1e12}, input::optional("loads are exact"),
                         "standard deviation of measured loads",
                         [](Draft& draft, double value) { draft.experiment.load_error = value; });
}

BasicKey<Draft> load_per_strength_key() {
  return quantity<Draft>("load_per_strength", area_dimension(), {0, 1e6, true},
                         input::optional("loads are given as forces"),
                         "load over strength, where loads are given as strengths",
                         [](Draft& draft, double value) { draft.load_per_strength = value; });
}

BasicKey<Draft> loads_key() {
  return file("loads",
              "peak_load_N, onset_load_N or strength_MPa, or other units; a column name names the rows",
              "one experiment", "loads of many experiments, one in each row", &Draft::loads);
}

template <class Target, class Choice, class Store>
BasicKey<Target> choice(std::string name, std::vector<std::string> words, std::string fallback,
                        std::string help, Store store) {
  return key<Target>(
      std::move(name), "word", input::by_default(std::move(fallback)), input::accepted_choice(words),
      std::move(help), [words](const Source& source) { return read_choice(source, words); },
      [store](Target& target, std::size_t number) { store(target, static_cast<Choice>(number)); });
}

std::vector<BasicKey<Draft>> path_keys() {
  const Range turn{-2 * std::numbers::pi, 2 * std::numbers::pi};
  return {
      file("path", "y_mm,z_mm", "the path was not observed",
           "the crack's path, from where it began; several arms, the compared one first, are separated by "
           "blank lines or told apart by a column arm",
           &Draft::path),
      quantity<Draft>("path_error", with_example(input::length_dimension, "0.2 mm"), error_range,
                      input::optional("points are exact"), "standard deviation of the points as read",
                      [](Draft& draft, double value) { draft.experiment.path_error = value; }),
      quantity<Draft>("path_error_length", with_example(input::length_dimension, "2 mm"),
                      input::positive_length, input::optional("the mean distance of the points"),
                      "correlation length of that error along the path",
                      [](Draft& draft, double value) { draft.experiment.path_error_length = value; }),
      flag<Draft>("arrested", "it runs on outside the picture, or through the body",
                  "true if the crack ended where the path ends",
                  [](Draft& draft, bool value) { draft.experiment.is_arrested = value; }),
      place<Draft>("origin", input::optional("the same origin"),
                   "where the origin of the files lies in the body",
                   [](Draft& draft, const plane::Point& value) { draft.origin = value; }),
      quantity<Draft>("angle", input::angle_dimension, turn, input::optional("0"),
                      "of the files' y axis in the body, from y towards z",
                      [](Draft& draft, double value) { draft.angle = value; }),
      choice<Draft, Mirror>("mirror", {"none", "y", "z"}, "\"none\"",
                            "axis of the files that is reversed, before they are turned",
                            [](Draft& draft, Mirror value) { draft.mirror = value; })};
}

std::vector<BasicKey<Draft>> load_keys() {
  return {quantity<Draft>("onset_load", with_example(force_dimension(), "134 N"), load_range,
                          input::optional("not measured"), "load at which the crack began to run",
                          [](Draft& draft, double value) { draft.experiment.onset_load = value; }),
          quantity<Draft>("peak_load", with_example(force_dimension(), "135 N"), load_range,
                          input::optional("the largest load of curve, if that is given"), "largest load",
                          [](Draft& draft, double value) { draft.experiment.peak_load = value; }),
          load_error_key(),
          file("curve", "displacement_mm,load_N", "not measured", "load over displacement", &Draft::curve),
          loads_key(),
          load_per_strength_key()};
}

void read_picture(const Source& source, Picture& picture) {
  const auto name = read_text(source, accepted_picture);
  if (!name) return;
  picture.file = source.context.folder / *name;
  const std::string kind = other_kind(picture.file);
  if (!is_taken(picture.file) || !kind.empty())
    source.report("{}: {}; give {}", input::shortened(picture.file.string(), 200),
                  kind.empty() ? "there is no such file" : "is " + kind, accepted_picture);
}

BasicKey<Picture> pixel_key() {
  return key<Picture>(
      "origin", "numbers", input::required(), pixel_form, "where the experiment's origin is in the picture",
      [](const Source& source) -> std::optional<plane::Point> {
        const auto elements = read_elements(source, 2, pixel_form);
        if (!elements) return {};
        const auto x = read_number((*elements)[0], pixels), y = read_number((*elements)[1], pixels);
        if (!x || !y) return {};
        return plane::Point{*x, *y};
      },
      [](Picture& picture, const plane::Point& value) { picture.origin = value; });
}

template <class Target>
BasicKey<Target> time_key(double Target::*member, std::string help) {
  return quantity<Target>("time", with_example(input::time_dimension, "40 us"), time_range, input::required(),
                          std::move(help),
                          [member](Target& target, double value) { target.*member = value; });
}

}  // namespace

const BasicTable<Draft>& top_table() {
  static const BasicTable<Draft> table{
      "", Occurrence::once, "loads alone", {loads_key(), load_error_key(), load_per_strength_key()}};
  return table;
}

const BasicTable<Draft>& experiment_table() {
  static const BasicTable<Draft> table = [] {
    BasicTable<Draft> made{"experiment", Occurrence::many, "an experiment", {}};
    made.keys.push_back(key<Draft>(
        "name", "text", input::required_unless("loads"), input::accepted_name("plate 3"), "its name",
        [](const Source& source) { return read_name(source, "plate 3"); },
        [](Draft& draft, std::string value) { draft.experiment.name = std::move(value); }));
    for (auto& each : path_keys()) made.keys.push_back(std::move(each));
    for (auto& each : load_keys()) made.keys.push_back(std::move(each));
    made.keys.push_back(file("tips", "time_us,y_mm,z_mm", "not observed",
                             "places of the crack's tip at times since it began to run", &Draft::tips));
    made.keys.push_back(
        quantity<Draft>("time_error", with_example(input::time_dimension, "1 us"), {0, 1e3},
                        input::optional("times are exact"), "standard deviation of the times",
                        [](Draft& draft, double value) { draft.experiment.time_error = value; }));
    return made;
  }();
  return table;
}

const BasicTable<Tip>& tip_table() {
  static const BasicTable<Tip> table{
      "experiment.tip",
      Occurrence::many,
      "the crack's tip at one moment",
      {time_key(&Tip::time, "since the crack began to run"),
       place<Tip>("at", input::required(), "place of the tip, in the axes of the files",
                  [](Tip& tip, const plane::Point& value) { tip.at = value; })}};
  return table;
}

const BasicTable<Picture>& picture_table() {
  static const BasicTable<Picture> table{
      "experiment.picture",
      Occurrence::many,
      "a photograph, for the report",
      {{"file",
        "file name",
        input::required(),
        accepted_picture,
        "the picture",
        [](const Source& source, Picture& picture, std::size_t) { read_picture(source, picture); },
        {}},
       time_key(&Picture::time, "since the crack began to run"),
       quantity<Picture>("scale", with_example(input::length_dimension, "0.05 mm"), {1e-9, 1},
                         input::required(), "length of one pixel",
                         [](Picture& picture, double value) { picture.scale = value; }),
       pixel_key(),
       choice<Picture, bool>("field", {"light", "dark"}, "\"dark\"", "of the polariscope",
                             [](Picture& picture, bool value) { picture.has_dark_field = value; }),
       flag<Picture>("reversed", "no", "true if the colours are reversed",
                     [](Picture& picture, bool value) { picture.is_reversed = value; })}};
  return table;
}

}  // namespace crackle::experiment
