// SPDX-License-Identifier: GPL-3.0-or-later
#include "values.h"

#include "common/failure.h"
#include "common/quantity_text.h"
#include "common/real.h"

#include <fmt/format.h>

#include <algorithm>
#include <charconv>
#include <cmath>
#include <system_error>

namespace crackle::input {

namespace {

constexpr std::size_t max_name = 60;

template <class Format>
std::string describe_range(const Range& range, Format format) {
  if (range.upper == infinity) {
    return fmt::format("{} {}", range.lower_open ? "above" : "at least", format(range.lower));
  }
  const bool from_to = !range.lower_open && !range.upper_open;
  if (from_to) return fmt::format("from {} to {}", format(range.lower), format(range.upper));
  return fmt::format("{} {} and {} {}", range.lower_open ? "above" : "at least", format(range.lower),
                     range.upper_open ? "below" : "up to", format(range.upper));
}

std::string describe_range(const Range& range, const Dimension& dimension) {
  return describe_range(
      range, [&](double bound) { return bound == 0 ? std::string("0") : format_quantity(bound, dimension); });
}

/// "a plain number without a unit" and the like, for a value of the wrong type.
std::string describe_wrong_type(const Value& value) {
  return fmt::format("{} is {}", value.source, describe(value.kind));
}

/// Messages about arrays and tables do not repeat their source, which may be long.
std::string what_is_given(const Value& value) {
  const bool compound = value.kind == ValueKind::array || value.kind == ValueKind::table;
  return compound ? std::string("this is ") + describe(value.kind) : describe_wrong_type(value);
}

}  // namespace

std::string name_without_article(const Dimension& dimension) {
  return dimension.name.substr(dimension.name.find(' ') + 1);
}

std::string quantity_form(const Dimension& dimension) {
  return fmt::format("{} such as \"{}\"", dimension.name, dimension.example);
}

std::string accepted(const Dimension& dimension, const Range& range) {
  return fmt::format("{} {}, such as \"{}\"", dimension.name, describe_range(range, dimension),
                     dimension.example);
}

std::string accepted_number(const Range& range) {
  return "a number " + describe_range(range, [](double bound) { return format_number(bound); });
}

std::string accepted_integer(std::int64_t lower, std::int64_t upper) {
  return fmt::format("a whole number from {} to {}", lower, upper);
}

std::string accepted_choice(const std::vector<std::string>& names) {
  std::string text;
  for (std::size_t i = 0; i < names.size(); ++i) {
    text += i == 0 ? "" : i + 1 == names.size() ? " or " : ", ";
    text += '"' + names[i] + '"';
  }
  return text;
}

std::optional<double> read_quantity(const Source& source, const Dimension& dimension, const Range& range) {
  const Value& value = source.value;
  const std::string advice = fmt::format("; give {}", quantity_form(dimension));
  if (value.kind == ValueKind::integer || value.kind == ValueKind::number)
    return source.report(
        "{} is a plain number without a unit; give {} with its unit, in quotes, such as "
        "\"{}\"",
        value.source, dimension.name, dimension.example);
  if (value.kind != ValueKind::string) return source.report(what_is_given(value) + advice);
  const Quantity quantity = source.context.units.read(value.string, dimension);
  switch (quantity.error) {
    case QuantityError::none:
      break;
    case QuantityError::no_number:
      return source.report(value.source + " is not a number with a unit" + advice);
    case QuantityError::no_unit:
      return source.report(value.source + " has no unit" + advice);
    case QuantityError::unknown_unit:
      return source.report("{} has the unknown unit \"{}\"{}", value.source, shortened(quantity.unit),
                           advice);
    case QuantityError::wrong_dimension:
      return source.report("{} does not have the dimension of {}{}", value.source, dimension.name, advice);
    case QuantityError::not_finite:
      return source.report(value.source + " is not a finite number; give " + accepted(dimension, range));
  }
  if (!range.contains(quantity.value))
    return source.report(value.source + " is out of range; give " + accepted(dimension, range));
  return quantity.value;
}

std::optional<double> read_number(const Source& source, const Range& range) {
  const Value& value = source.value;
  if (value.kind != ValueKind::integer && value.kind != ValueKind::number)
    return source.report("{}; give {}, without quotes", what_is_given(value), accepted_number(range));
  if (!value.representable || !std::isfinite(value.number))
    return source.report(value.source + " is not a finite number; give " + accepted_number(range));
  if (!range.contains(value.number))
    return source.report(value.source + " is out of range; give " + accepted_number(range));
  return value.number;
}

std::optional<std::int64_t> read_integer(const Source& source, std::int64_t lower, std::int64_t upper) {
  const Value& value = source.value;
  const std::string advice = "; give " + accepted_integer(lower, upper);
  if (value.kind == ValueKind::number) return source.report(value.source + " is not a whole number" + advice);
  if (value.kind != ValueKind::integer)
    return source.report(what_is_given(value) + advice + ", without quotes");
  if (!value.representable || value.integer < lower || value.integer > upper)
    return source.report(value.source + " is out of range" + advice);
  return value.integer;
}

std::optional<std::string> read_text(const Source& source, const std::string& accepted) {
  if (source.value.kind != ValueKind::string || source.value.string.empty())
    return source.report(
        "{}; give {}",
        source.value.kind == ValueKind::string ? "the string is empty" : what_is_given(source.value),
        accepted);
  return source.value.string;
}

std::string accepted_name(const std::string& example) {
  return fmt::format("a text of 1 to {} characters without \"/\" or control characters, such as \"{}\"",
                     max_name, example);
}

std::optional<std::string> read_name(const Source& source, const std::string& example) {
  const std::string accepted = accepted_name(example);
  const auto name = read_text(source, accepted);
  if (!name) return {};
  if (name->size() > max_name) return source.report("has {} characters; give {}", name->size(), accepted);
  // The name is used for a group in the sample files.
  const auto is_control = [](char c) { return static_cast<unsigned char>(c) < 0x20 || c == 0x7f; };
  if (std::ranges::any_of(*name, is_control) || name->find('/') != std::string::npos || *name == "." ||
      *name == "..")
    return source.report("{} cannot be used; give {}", source.value.source, accepted);
  return name;
}

std::optional<std::size_t> read_choice(const Source& source, const std::vector<std::string>& names) {
  const Value& value = source.value;
  if (value.kind != ValueKind::string)
    return source.report(what_is_given(value) + "; give " + accepted_choice(names));
  const auto found = std::find(names.begin(), names.end(), value.string);
  if (found == names.end())
    return source.report(value.source + " is not known; give " + accepted_choice(names));
  return static_cast<std::size_t>(found - names.begin());
}

std::optional<std::vector<Source>> read_elements(const Source& source, std::size_t count,
                                                 const std::string& accepted) {
  const Value& value = source.value;
  if (value.kind != ValueKind::array) return source.report(what_is_given(value) + "; give " + accepted);
  if (value.elements.empty() || (count != 0 && value.elements.size() != count)) {
    const std::size_t n = value.elements.size();
    return source.report("the array has {}; give {}", count_text(n, "element"), accepted);
  }
  std::vector<Source> elements;
  for (std::size_t i = 0; i < value.elements.size(); ++i) {
    elements.push_back({value.elements[i], fmt::format("{}[{}]", source.key, i), source.context});
  }
  return elements;
}

double read_value(const std::string& text, const std::string& si_unit) {
  double value = 0;
  if (si_unit.empty() || si_unit == "1") {
    const char* const end = text.data() + text.size();
    const auto [rest, status] = std::from_chars(text.data(), end, value);
    if (status != std::errc{} || rest != end || !std::isfinite(value))
      fail("'{}' is not a plain number; give one such as 0.5", shortened(text));
    return value;
  }
  const Quantity quantity = UnitSystem::shared().read(text, {"a value", si_unit, "1 " + si_unit, 0, {}});
  if (quantity.error != QuantityError::none)
    fail("'{}' is not a value in {}; give one such as \"1 {}\"", shortened(text), si_unit, si_unit);
  return quantity.value;
}

}  // namespace crackle::input
