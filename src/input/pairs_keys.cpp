// SPDX-License-Identifier: GPL-3.0-or-later
// Keys whose values are tables of pairs.
#include "schema.h"

namespace crackle::input {

namespace {

/// Arguments closer than this (a femtosecond or -metre) give slopes that no computation can follow.
constexpr double least_distance = 1e-15;

}  // namespace

Key pairs_key(std::string name, Access<FactorTable> access, const Pairs& pairs, Requirement requirement,
              std::string help) {
  const std::string form =
      fmt::format("an array of [{}, {}], such as {}", pairs.argument, pairs.value, pairs.example);
  return {std::move(name),
          fmt::format("{} and {}", pairs.argument, pairs.value),
          std::move(requirement),
          fmt::format("{}, {}s ascending{}", form, pairs.argument,
                      pairs.argument_range.lower == 0 ? " from 0" : ""),
          std::move(help),
          [=](const Source& source, Parameters& parameters, std::size_t i) {
            const auto rows = read_elements(source, 0, form);
            if (!rows) return;
            auto& all = access(parameters, i);
            for (const Source& row : *rows) {
              const auto pair = read_elements(row, 2, form);
              if (!pair) continue;
              const auto argument = read_quantity((*pair)[0], pairs.argument_dimension, pairs.argument_range);
              const auto value = pairs.value_dimension
                                     ? read_quantity((*pair)[1], *pairs.value_dimension, pairs.value_range)
                                     : read_number((*pair)[1], pairs.value_range);
              if (!argument || !value) continue;
              if (!all.empty() && *argument <= all.back().first)
                (*pair)[0].report("{} is not {} the {} before it; give ascending {}s",
                                  (*pair)[0].value.source, pairs.after, pairs.argument, pairs.argument);
              else if (!all.empty() && *argument - all.back().first < least_distance)
                (*pair)[0].report("{} is less than {:g} {} {} the {} before it; give {}s further apart",
                                  (*pair)[0].value.source, least_distance, pairs.argument_dimension.si_unit,
                                  pairs.after, pairs.argument, pairs.argument);
              all.emplace_back(*argument, *value);
            }
          },
          [=](Parameters& parameters, std::size_t i) -> std::optional<std::string> {
            const auto& all = access(parameters, i);
            if (all.empty()) return {};
            std::vector<std::string> rows;
            for (const auto& [argument, value] : all)
              rows.push_back(bracketed({format_quantity(argument, pairs.argument_dimension),
                                        pairs.value_dimension ? format_quantity(value, *pairs.value_dimension)
                                                              : format_number(value)}));
            return bracketed(rows);
          }};
}

Key history_key(Access<FactorTable> access, std::string help) {
  return pairs_key("history", std::move(access),
                   {.argument = "time",
                    .value = "factor",
                    .example = "[[\"0 s\", 0], [\"10 s\", 1]]",
                    .argument_dimension = with_example(time_dimension, "10 s"),
                    .argument_range = {0, 1e12},
                    .value_dimension = {},
                    .value_range = {-1e12, 1e12},
                    .after = "later than"},
                   optional("constant in time"), std::move(help));
}

std::vector<Key> profile_keys(const std::string& name, const Access<std::optional<Profile>>& access,
                              const std::string& help) {
  const auto profile = [access](Parameters& parameters, std::size_t i) -> Profile& {
    auto& one = access(parameters, i);
    return one ? *one : one.emplace();
  };
  Key along = choice_key<std::size_t>(
      name + ".along",
      [=](Parameters & parameters, std::size_t i) -> auto& { return profile(parameters, i).axis; },
      {{"x", 0}, {"y", 1}, {"z", 2}}, optional("the same everywhere"), "the coordinate of the table");
  Key table = pairs_key(
      name + ".table",
      [=](Parameters & parameters, std::size_t i) -> auto& { return profile(parameters, i).table; },
      {.argument = "length",
       .value = "factor",
       .example = "[[\"0 mm\", 0], [\"10 mm\", 1]]",
       .argument_dimension = length_dimension,
       .argument_range = coordinate,
       .value_dimension = {},
       .value_range = {-1e12, 1e12}},
      optional("the same everywhere"), help);
  for (Key* key : {&along, &table})
    key->show = [access, show = key->show](Parameters& parameters,
                                           std::size_t i) -> std::optional<std::string> {
      if (!access(parameters, i)) return {};
      return show(parameters, i);
    };
  return {std::move(along), std::move(table)};
}

}  // namespace crackle::input
