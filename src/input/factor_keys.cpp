// SPDX-License-Identifier: GPL-3.0-or-later
#include "schema.h"

namespace crackle::input {

namespace {

/// What the factors of a table depend on.
struct Argument {
  std::string name;  ///< with its article: "a time"
  Dimension dimension;
  Range range;
  std::string earlier;        ///< than the entry before: "not later than the time before it"
  std::string form, entry;    ///< an example of the table, and of one entry
  std::string also_accepted;  ///< for the table of keys
};

Key factor_table_key(std::string name, const Argument& argument, Access<FactorTable> access,
                     Requirement requirement, std::string help) {
  return {std::move(name),
          argument.name.substr(argument.name.find(' ') + 1) + " and number",
          std::move(requirement),
          argument.form + argument.also_accepted,
          std::move(help),
          [=](const Source& source, Parameters& parameters, std::size_t i) {
            const auto points = read_elements(source, 0, argument.form);
            if (!points) return;
            FactorTable& table = access(parameters, i);
            for (const Source& point : *points) {
              const auto pair = read_elements(
                  point, 2, fmt::format("{} and a factor, such as {}", argument.name, argument.entry));
              if (!pair) continue;
              const auto at = read_quantity((*pair)[0], argument.dimension, argument.range);
              const auto factor = read_number((*pair)[1], {-1e12, 1e12});
              if (!at || !factor) continue;
              if (!table.empty() && *at <= table.back().first)
                (*pair)[0].report("{} is {}; give ascending {}s", (*pair)[0].value.source, argument.earlier,
                                  argument.name.substr(argument.name.find(' ') + 1));
              table.emplace_back(*at, *factor);
            }
          },
          [=](Parameters& parameters, std::size_t i) -> std::optional<std::string> {
            const FactorTable& table = access(parameters, i);
            if (table.empty()) return {};
            std::vector<std::string> items;
            for (const auto& [at, factor] : table)
              items.push_back(bracketed({format_quantity(at, argument.dimension), format_number(factor)}));
            return bracketed(items);
          }};
}

}  // namespace

Key history_key(Access<FactorTable> access, std::string help) {
  return factor_table_key("history",
                          {"a time",
                           with_example(time_dimension, "10 s"),
                           {0, 1e12},
                           "not later than the time before it",
                           "an array of [time, factor], such as [[\"0 s\", 0], [\"10 s\", 1]]",
                           "[\"10 s\", 1]",
                           ", times ascending from 0"},
                          std::move(access), optional("constant in time"), std::move(help));
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
  Key table = factor_table_key(
      name + ".table",
      {"a length", length_dimension, coordinate, "not above the length before it",
       "an array of [coordinate, factor], such as [[\"0 mm\", 0], [\"10 mm\", 1]]", "[\"10 mm\", 1]",
       ", ascending"},
      [=](Parameters & parameters, std::size_t i) -> auto& { return profile(parameters, i).table; },
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
