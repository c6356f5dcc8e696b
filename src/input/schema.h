// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "common/real.h"
#include "table.h"
#include "values.h"

#include "input/parameters.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <array>
#include <functional>
#include <optional>
#include <string>
#include <type_traits>
#include <utility>
#include <vector>

/// The keys of the input file. Each is declared once, in schema.cpp; reading, checking, the echo of the
/// resolved input and the table of keys are all derived from that declaration.
namespace crackle::input {

/// Access to a value in the parameters; `index` is the number of the table in an array of tables.
template <class T>
using Access = std::function<T&(Parameters& parameters, std::size_t index)>;

using Key = BasicKey<Parameters>;
using Table = BasicTable<Parameters>;

/// All tables with their keys, in the order of reading and display.
const std::vector<Table>& schema();

/// Their names.
std::vector<KnownTable> known_tables();

/// [specimen], [[specimen.hole]], [[specimen.notch]] and [[specimen.region]].
std::vector<Table> specimen_tables();
Table crack_table();
Table flaws_table();

/// True if its mean is the input's own value of the key.
bool has_own_mean(const RandomInput& random);

/// Reads a table of a distribution and its parameters, as in [[random]].
/// @param random with key and unit
void read_distribution(const Source& source, RandomInput& random);
std::string show_distribution(const RandomInput& random);
/// Reports parameters that are missing, too many or inconsistent.
/// @param table its key
void check_distribution(const RandomInput& random, const std::string& table, Findings& findings);

/// [material] with its parts, and [[interface]].
std::vector<Table> material_tables();
Table map_table();

/// Keys of [[boundary]], whose values depend on each other.
Table boundary_table();

/// [[initial.stress]].
Table initial_stress_table();
/// [[load]]
Table load_table();
/// [[tool]]
Table tool_table();
/// [contact]
Table contact_table();

/// [output] and [[output.probe]].
Table output_table();
Table probe_table();

/// [[random]], [[correlation]] and [[sweep]], which refer to keys of other tables.
Table random_table();
Table correlation_table();
Table sweep_table();

/// The key of the schema at a path such as "specimen.notch[0].depth" or "boundary[1].rate[2]", or null.
const Key* find_key(const std::string& path);
/// "did you mean "material.poisson_ratio"?" of a path that is not in the schema, or "give " and what is
/// accepted.
std::string advice_on_key(const std::string& path, const std::string& accepted);

// The kinds of keys.

Key quantity_key(std::string name, Access<double> access, const Dimension& dimension, Range range,
                 Requirement requirement, std::string help);
/// A positive quantity that may be omitted; its value then stays 0 and is not shown.
Key optional_quantity_key(std::string name, Access<double> access, const Dimension& dimension, Range range,
                          Requirement requirement, std::string help);
/// A quantity that may be omitted, and may be 0.
Key optional_quantity_key(std::string name, Access<std::optional<double>> access, const Dimension& dimension,
                          Range range, Requirement requirement, std::string help);
/// The key, hidden where a condition does not hold.
Key shown_if(Key key, std::function<bool(const Parameters& parameters, std::size_t index)> condition);
/// The key, hidden while its value is 0, which means not given.
Key hidden_at_zero(Key key, const Access<double>& access);
/// A text, hidden while it is empty, which means not given.
Key text_key(std::string name, Access<std::string> access, Requirement requirement, std::string accepted,
             std::string help);
/// One that may name a group in a file.
Key name_key(Access<std::string> access, Requirement requirement, const std::string& example,
             std::string help);

/// `between`, the names of two things.
/// @param form of both, @param element of one
Key pair_key(Access<std::array<std::string, 2>> access, const std::string& form, const std::string& element,
             std::string help);
/// An energy per area; the error for a stress intensity refers to its key.
Key toughness_key(const Access<double>& access, Requirement requirement, std::string help);
/// The Tuler-Butcher impulse, whose dimension depends on the exponent.
Key impulse_key(const Access<double>& access, Requirement requirement, std::string help);
/// How long a breaking tetrahedron loses its stiffness.
Key release_time_key(Access<std::optional<double>> access, Requirement requirement, std::string help);
Key release_speed_key(const Access<double>& access, Requirement requirement, std::string help);
/// A time or the word "auto", which leaves the value empty.
Key automatic_time_key(std::string name, Access<std::optional<double>> access, const std::string& example,
                       std::string help);
Key number_key(std::string name, Access<double> access, Range range, Requirement requirement,
               std::string help);
/// A positive number that may be omitted; its value then stays 0 and is not shown.
Key optional_number_key(std::string name, Access<double> access, Range range, std::string unset,
                        std::string help);
/// An interval of a coordinate that may be omitted; it then stays unbounded and is not shown.
/// @param example its two lengths
/// @param whole meaning of a missing interval
/// @param may_be_empty allows two equal lengths
Key range_key(std::string name, Access<std::pair<double, double>> access,
              const std::pair<std::string, std::string>& example, std::string whole, std::string help,
              bool may_be_empty = false);

/// The contents of an array of pairs.
struct Pairs {
  std::string argument, value;  ///< "time", "factor"
  std::string example;          ///< "[[\"0 s\", 0], [\"10 s\", 1]]"
  Dimension argument_dimension;
  Range argument_range;
  std::optional<Dimension> value_dimension;  ///< empty: a number
  Range value_range;
  std::string after = "above";  ///< one argument is, than the one before
};
/// Pairs with ascending arguments, shown if there are any.
Key pairs_key(std::string name, Access<FactorTable> access, const Pairs& pairs, Requirement requirement,
              std::string help);
/// Factors at times.
Key history_key(Access<FactorTable> access, std::string help);
/// A factor over a coordinate that may be omitted: "name.along" and "name.table". The profile exists once one
/// of them is given.
std::vector<Key> profile_keys(const std::string& name, const Access<std::optional<Profile>>& access,
                              const std::string& help);

/// A key whose value is parsed by `read`, which may fail, and written by `show`.
template <class T, class Read, class Show>
Key value_key(std::string name, std::string dimension, Requirement requirement, std::string accepted,
              std::string help, Access<T> access, Read read, Show show) {
  return {std::move(name),
          std::move(dimension),
          std::move(requirement),
          std::move(accepted),
          std::move(help),
          [=](const Source& source, Parameters& parameters, std::size_t i) {
            if (const auto value = read(source)) access(parameters, i) = static_cast<T>(*value);
          },
          [=](Parameters& parameters, std::size_t i) { return show(access(parameters, i)); }};
}

template <class Integer>
Key integer_key(std::string name, Access<Integer> access, std::int64_t lower, std::int64_t upper,
                Requirement requirement, std::string help) {
  return value_key(
      name, "integer", requirement, accepted_integer(lower, upper), help, access,
      [=](const Source& source) { return read_integer(source, lower, upper); },
      [](Integer value) { return std::to_string(value); });
}

/// One of the words of `choices`.
template <class Enum>
Key choice_key(std::string name, Access<Enum> access, std::vector<std::pair<std::string, Enum>> choices,
               Requirement requirement, std::string help) {
  std::vector<std::string> names;
  for (const auto& choice : choices) names.push_back(choice.first);
  return value_key(
      name, "word", requirement, accepted_choice(names), help, access,
      [=](const Source& source) -> std::optional<Enum> {
        const auto index = read_choice(source, names);
        return index ? std::optional(choices[*index].second) : std::nullopt;
      },
      [=](Enum value) {
        return std::ranges::find(choices, value, &std::pair<std::string, Enum>::second)->first;
      });
}

/// "[a, b]"
inline std::string bracketed(const std::vector<std::string>& items) {
  return fmt::format("[{}]", fmt::join(items, ", "));
}

/// Which of the words an array has; it does not repeat them.
/// @param form that is accepted
template <std::size_t n>
std::array<bool, n> read_words(const Source& source, const std::array<const char*, n>& words,
                               const char* form) {
  std::array<bool, n> has{};
  const auto elements = read_elements(source, 0, form);
  for (std::size_t k = 0; elements && k < elements->size(); ++k) {
    const Source& element = (*elements)[k];
    const auto word = read_choice(element, {words.begin(), words.end()});
    if (!word) continue;
    if (has[*word]) element.report("{} appears twice; give {}", element.value.source, form);
    has[*word] = true;
  }
  return has;
}

template <std::size_t n>
std::string show_words(const std::array<bool, n>& has, const std::array<const char*, n>& words) {
  std::vector<std::string> items;
  for (std::size_t k = 0; k < n; ++k)
    if (has[k]) items.emplace_back(words[k]);
  return bracketed(items);
}

inline constexpr const char* distinct_axes = "an array of distinct axes from \"x\", \"y\", \"z\"";
inline std::array<bool, 3> read_axes(const Source& source) {
  return read_words(source, axis_names, distinct_axes);
}
inline std::string show_axes(const std::array<bool, 3>& axes) {
  return show_words(axes, axis_names);
}

/// Lengths: as many as the array has, or at least one in a vector, which is hidden while it is empty.
template <class Lengths>
Key lengths_key(std::string name, Access<Lengths> access, const std::string& form, Range range,
                Requirement requirement, std::string help) {
  constexpr bool is_list = std::is_same_v<Lengths, std::vector<double>>;
  return {std::move(name),
          "length",
          std::move(requirement),
          form,
          std::move(help),
          [=](const Source& source, Parameters& parameters, std::size_t i) {
            Lengths& lengths = access(parameters, i);
            const auto elements = read_elements(source, is_list ? 0 : lengths.size(), form);
            for (std::size_t k = 0; elements && k < elements->size(); ++k) {
              const auto length = read_quantity((*elements)[k], length_dimension, range);
              if constexpr (is_list)
                lengths.push_back(length.value_or(not_a_number));
              else if (length)
                lengths[k] = *length;
            }
          },
          [=](Parameters& parameters, std::size_t i) -> std::optional<std::string> {
            std::vector<std::string> items;
            for (const double length : access(parameters, i)) items.push_back(show(length));
            if (items.empty()) return {};
            return bracketed(items);
          }};
}

/// Three numbers, not all 0: the components of a direction.
Key direction_key(std::string name, Access<Vector> access, Requirement requirement, std::string help);

/// The faces from this one to the last, for choice_key.
inline std::vector<std::pair<std::string, plane::Face>> faces_from(plane::Face first) {
  std::vector<std::pair<std::string, plane::Face>> choices;
  for (auto i = static_cast<std::size_t>(first); i < plane::face_names.size(); ++i) {
    choices.emplace_back(plane::face_names[i], static_cast<plane::Face>(i));
  }
  return choices;
}

// Ranges. The outer bounds only keep mistakes such as "5e300 mm" out of the arithmetic.

inline constexpr Range positive_length{1e-9, 1e3};
inline constexpr Range positive_time{1e-15, 1e6};
inline constexpr Range positive_stress{0, 1e14, true};
inline constexpr Range coordinate{-1e3, 1e3};

}  // namespace crackle::input
