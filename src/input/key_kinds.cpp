// SPDX-License-Identifier: GPL-3.0-or-later
// The kinds of keys.
#include "schema.h"

namespace crackle::input {

Key shown_if(Key key, std::function<bool(const Parameters& parameters, std::size_t index)> condition) {
  key.show = [condition = std::move(condition), show = key.show](
                 Parameters& parameters, std::size_t i) -> std::optional<std::string> {
    if (!condition(parameters, i)) return {};
    return show(parameters, i);
  };
  return key;
}

Key hidden_at_zero(Key key, const Access<double>& access) {
  key.show = [=, show = key.show](Parameters& parameters, std::size_t i) -> std::optional<std::string> {
    if (access(parameters, i) == 0) return {};
    return show(parameters, i);
  };
  return key;
}

Key text_key(std::string name, Access<std::string> access, Requirement requirement, std::string accepted,
             std::string help) {
  return {std::move(name),
          "text",
          std::move(requirement),
          accepted,
          std::move(help),
          [=](const Source& source, Parameters& parameters, std::size_t i) {
            if (const auto text = read_text(source, accepted)) access(parameters, i) = *text;
          },
          [=](Parameters& parameters, std::size_t i) -> std::optional<std::string> {
            const std::string& text = access(parameters, i);
            if (text.empty()) return {};
            return text;
          }};
}

Key name_key(Access<std::string> access, Requirement requirement, const std::string& example,
             std::string help) {
  Key key = text_key("name", access, std::move(requirement), accepted_name(example), std::move(help));
  key.read = [=](const Source& source, Parameters& parameters, std::size_t i) {
    if (const auto name = read_name(source, example)) access(parameters, i) = *name;
  };
  return key;
}

Key pair_key(Access<std::array<std::string, 2>> access, const std::string& form, const std::string& element,
             std::string help) {
  return {"between",
          "two names",
          required(),
          form,
          std::move(help),
          [=](const Source& source, Parameters& parameters, std::size_t i) {
            const auto names = read_elements(source, 2, form);
            for (std::size_t k = 0; names && k < 2; ++k)
              if (const auto name = read_text((*names)[k], element)) access(parameters, i)[k] = *name;
          },
          [=](Parameters& parameters, std::size_t i) {
            const auto& [one, other] = access(parameters, i);
            return bracketed({one, other});
          }};
}

Key direction_key(std::string name, Access<Vector> access, Requirement requirement, std::string help) {
  const std::string form = "three numbers, not all 0, such as [1, 0, 0]";
  return {std::move(name),
          "number",
          std::move(requirement),
          form,
          std::move(help),
          [=](const Source& source, Parameters& parameters, std::size_t i) {
            const auto elements = read_elements(source, 3, form);
            if (!elements) return;
            Vector direction{};
            for (std::size_t axis = 0; axis < 3; ++axis) {
              const auto value = read_number((*elements)[axis], {-1e6, 1e6});
              if (!value) return;
              direction[axis] = *value;
            }
            if (norm(direction) > 1e-6)
              access(parameters, i) = direction;
            else
              source.report("has no direction; give {}", form);
          },
          [=](Parameters& parameters, std::size_t i) -> std::optional<std::string> {
            std::vector<std::string> components;
            for (const double component : access(parameters, i))
              components.push_back(format_number(component));
            return bracketed(components);
          }};
}

Key quantity_key(std::string name, Access<double> access, const Dimension& dimension, Range range,
                 Requirement requirement, std::string help) {
  return value_key(
      name, name_without_article(dimension), requirement, quantity_form(dimension), help, access,
      [=](const Source& source) { return read_quantity(source, dimension, range); },
      [=](double value) { return format_quantity(value, dimension); });
}

Key optional_quantity_key(std::string name, Access<double> access, const Dimension& dimension, Range range,
                          Requirement requirement, std::string help) {
  return hidden_at_zero(
      quantity_key(std::move(name), access, dimension, range, std::move(requirement), std::move(help)),
      access);
}

Key optional_quantity_key(std::string name, Access<std::optional<double>> access, const Dimension& dimension,
                          Range range, Requirement requirement, std::string help) {
  return {std::move(name),
          name_without_article(dimension),
          std::move(requirement),
          quantity_form(dimension),
          std::move(help),
          [=](const Source& source, Parameters& parameters, std::size_t i) {
            if (const auto value = read_quantity(source, dimension, range)) access(parameters, i) = *value;
          },
          [=](Parameters& parameters, std::size_t i) -> std::optional<std::string> {
            const std::optional<double>& value = access(parameters, i);
            if (!value) return {};
            return format_quantity(*value, dimension);
          }};
}

Key toughness_key(const Access<double>& access, Requirement requirement, std::string help) {
  Key key = optional_quantity_key("toughness", access, energy_per_area_dimension, {0, 1e9, true},
                                  std::move(requirement), std::move(help));
  key.read = [read = key.read](const Source& source, Parameters& parameters, std::size_t i) {
    const Value& value = source.value;
    if (value.kind == ValueKind::string &&
        source.context.units.read(value.string, stress_intensity_dimension).error == QuantityError::none)
      source.report("{} is a stress intensity, K_Ic; give it as {}", value.source,
                    source.key.substr(0, source.key.rfind('.') + 1) + "fracture_toughness");
    else
      read(source, parameters, i);
  };
  return key;
}

Key impulse_key(const Access<double>& access, Requirement requirement, std::string help) {
  return {"impulse",
          "stress^exponent time",
          std::move(requirement),
          "a stress^exponent times a time, above 0, such as \"1e-8 MPa^2 s\" for exponent = 2",
          std::move(help),
          [=](const Source& source, Parameters& parameters, std::size_t i) {
            // Without a valid exponent the dimension is unknown. Materials are read before it.
            if (source.context.findings.faulty("fracture.exponent")) return;
            const Value* const root = source.context.root;
            const Value* const exponent = root != nullptr ? find_path(*root, "fracture.exponent") : nullptr;
            const Dimension dimension =
                impulse_dimension(exponent != nullptr && exponent->number > 0 ? exponent->number
                                                                              : parameters.fracture.exponent);
            if (const auto value = read_quantity(source, dimension, {0, infinity, true}))
              access(parameters, i) = *value;
          },
          [=](Parameters& parameters, std::size_t i) {
            return format_quantity(access(parameters, i), impulse_dimension(parameters.fracture.exponent));
          }};
}

Key release_time_key(Access<std::optional<double>> access, Requirement requirement, std::string help) {
  return optional_quantity_key("release_time", std::move(access), with_example(time_dimension, "0.2 us"),
                               {0, 1}, std::move(requirement), std::move(help));
}

Key release_speed_key(const Access<double>& access, Requirement requirement, std::string help) {
  return optional_quantity_key("release_speed", access,
                               with_example(value_dimension(BoundaryKind::velocity), "780 m/s"),
                               {0, 1e6, true}, std::move(requirement), std::move(help));
}

Key automatic_time_key(std::string name, Access<std::optional<double>> access, const std::string& example,
                       std::string help) {
  const Dimension dimension = with_example(time_dimension, example);
  return {std::move(name),
          "time",
          by_default("\"auto\""),
          fmt::format("\"auto\" or {}", quantity_form(dimension)),
          std::move(help),
          [=](const Source& source, Parameters& parameters, std::size_t i) {
            const bool text = source.value.kind == ValueKind::string;
            if (text && source.value.string == "auto") {
              access(parameters, i).reset();
            } else if (text && source.value.string.find_first_of("0123456789") == std::string::npos) {
              source.report("{} is not known; give \"auto\" or a time such as \"{}\"", source.value.source,
                            example);
            } else if (const auto value = read_quantity(source, dimension, positive_time)) {
              access(parameters, i) = *value;
            }
          },
          [=](Parameters& parameters, std::size_t i) -> std::string {
            const std::optional<double>& value = access(parameters, i);
            return value ? format_quantity(*value, dimension) : "auto";
          }};
}

Key number_key(std::string name, Access<double> access, Range range, Requirement requirement,
               std::string help) {
  return value_key(
      name, "number", requirement, accepted_number(range), help, access,
      [=](const Source& source) { return read_number(source, range); }, format_number);
}

Key optional_number_key(std::string name, Access<double> access, Range range, std::string unset,
                        std::string help) {
  return hidden_at_zero(
      number_key(std::move(name), access, range, optional(std::move(unset)), std::move(help)), access);
}

Key range_key(std::string name, Access<std::pair<double, double>> access,
              const std::pair<std::string, std::string>& example, std::string whole, std::string help,
              bool may_be_empty) {
  const std::string form =
      fmt::format("two lengths, the smaller first{}, such as [\"{}\", \"{}\"]",
                  may_be_empty ? " (or the same twice)" : "", example.first, example.second);
  return {std::move(name),
          "length",
          optional(std::move(whole)),
          form,
          std::move(help),
          [=](const Source& source, Parameters& parameters, std::size_t i) {
            const auto ends = read_elements(source, 2, form);
            if (!ends) return;
            const auto lower = read_quantity((*ends)[0], length_dimension, coordinate);
            const auto upper = read_quantity((*ends)[1], length_dimension, coordinate);
            if (!lower || !upper) return;
            if (*lower > *upper || (*lower == *upper && !may_be_empty)) {
              source.report("{} is not below {}; give {}", (*ends)[0].value.source, (*ends)[1].value.source,
                            form);
              return;
            }
            access(parameters, i) = {*lower, *upper};
          },
          [=](Parameters& parameters, std::size_t i) -> std::optional<std::string> {
            const auto [lower, upper] = access(parameters, i);
            if (lower == -infinity) return {};
            return bracketed({show(lower), show(upper)});
          }};
}

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
