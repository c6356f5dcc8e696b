// SPDX-License-Identifier: GPL-3.0-or-later
#include "units.h"

#include "common/real.h"

#include <fmt/format.h>
#include <udunits2.h>

#include <algorithm>
#include <array>
#include <charconv>
#include <cmath>
#include <regex>
#include <stdexcept>
#include <utility>

namespace crackle::input {

namespace {

constexpr std::size_t max_text = 200;  // of a quantity with a unit

using Unit = std::unique_ptr<ut_unit, void (*)(ut_unit*)>;
using Converter = std::unique_ptr<cv_converter, void (*)(cv_converter*)>;

/// Products, quotients and small integer powers of names, or one over them. UDUNITS accepts far more as a
/// unit ("mm 3", "m @ 5", "lg(re 1 m)", "s since 2000"), which in an input file can only be a mistake.
bool looks_like_unit(const std::string& text) {
  // Letters are those of ASCII and all non-ASCII bytes of UTF-8.
  static const std::regex units(
      R"((?:1 ?/ ?)?(?=[^)./* ])(?:(?:[^\x01-@[-`{-\x7f]|\))(?:\^?[-+]?[0-9]{1,2})?|[ ./*(])+)");
  return text == "%" || (text.size() <= 80 && std::regex_match(text, units));
}

/// The text with the signs of typeset pages in the form that is read: "MPa sqrt(m)" of "MPa √m", "m^0.5" of
/// "m½", "-5" with a hyphen.
std::string plain_text(const std::string& text) {
  static const std::regex root("√ *(?:\\(([^()]*)\\)|([A-Za-z]+))");
  static const std::array<std::pair<std::string_view, std::string_view>, 9> signs{{{"^½", "^0.5"},
                                                                                   {"½", "^0.5"},
                                                                                   {"\u2212", "-"},
                                                                                   {"\u00b7", " "},
                                                                                   {"\u22c5", " "},
                                                                                   {"\u00a0", " "},
                                                                                   {"\u2009", " "},
                                                                                   {"\u202f", " "},
                                                                                   {"\u03bc", "\u00b5"}}};
  if (std::ranges::all_of(text, [](char c) { return static_cast<unsigned char>(c) < 0x80; })) return text;
  std::string plain = text;
  for (const auto& [sign, meaning] : signs)
    for (std::size_t at = 0; (at = plain.find(sign, at)) != std::string::npos; at += meaning.size())
      plain.replace(at, sign.size(), meaning);
  return plain.size() <= max_text ? std::regex_replace(plain, root, "sqrt($1$2)") : plain;
}

/// SI value of one `unit` [si_unit]; 0 if it is not a unit, NaN for another dimension.
double factor_to(ut_system* system, const std::string& unit, const std::string& si_unit) {
  if (!looks_like_unit(unit)) return 0;
  const Unit from(ut_parse(system, unit.c_str(), UT_UTF8), ut_free);
  if (!from) return 0;
  const Unit to(ut_parse(system, si_unit.c_str(), UT_UTF8), ut_free);
  if (!to) throw std::logic_error("UDUNITS does not know " + si_unit);
  const double other_dimension = not_a_number;
  if (!ut_are_convertible(from.get(), to.get())) return other_dimension;
  const Converter converter(ut_get_converter(from.get(), to.get()), cv_free);
  if (!converter) return other_dimension;
  // UDUNITS also converts reciprocals (Hz to s), logarithms and offsets; only a factor is a valid change of
  // unit.
  const double one = cv_convert_double(converter.get(), 1.0);
  const bool proportional = cv_convert_double(converter.get(), 0.0) == 0 &&
                            std::abs(cv_convert_double(converter.get(), 2.0) - 2 * one) <= 1e-12 * one;
  return proportional ? one : other_dimension;
}

/// The square of a unit that may contain roots, in UDUNITS syntax: "MPa^2 m^1" for "MPa m^0.5", "MPa sqrt(m)"
/// or "MPa m^(1/2)". Empty if the text is not such a unit.
std::string square_of(const std::string& unit) {
  if (unit.size() > 80) return {};
  static const std::regex factors(
      R"( *([*./]?) *(?:sqrt\(([A-Za-z]+)\)|([A-Za-z]+)(?:(?:\^|\*\*)\(?([-+]?[0-9]{1,2})(?:(\.[0-9]{1,2})|/([0-9]{1,2}))?\)?)?))");
  std::string square;
  auto at = unit.cbegin();
  for (std::smatch factor;
       std::regex_search(at, unit.cend(), factor, factors, std::regex_constants::match_continuous);
       at = factor[0].second) {
    double exponent = factor[2].matched ? 0.5 : 1;
    if (factor[4].matched) exponent = std::stod(factor[4].str() + factor[5].str());
    if (factor[6].matched) exponent /= std::stod(factor[6].str());
    if (factor[1] == "/") exponent = -exponent;
    const double twice = 2 * exponent;
    if (twice != std::round(twice) || std::abs(twice) > 20) return {};
    square += fmt::format(" {}^{}", (factor[2].matched ? factor[2] : factor[3]).str(), std::lround(twice));
  }
  return at == unit.cend() ? std::string(trimmed(square)) : std::string();
}

}  // namespace

std::string_view trimmed(std::string_view text) {
  constexpr const char* blanks = " \t\r";
  const auto first = text.find_first_not_of(blanks);
  if (first == std::string_view::npos) return {};
  return text.substr(first, text.find_last_not_of(blanks) - first + 1);
}

UnitSystem::UnitSystem() : system_(nullptr, ut_free_system) {
  ut_set_error_message_handler(ut_ignore);
  system_.reset(ut_read_xml(nullptr));
  if (!system_) throw std::runtime_error("UDUNITS: the unit data base (udunits2.xml) cannot be read");
}

Quantity UnitSystem::convert(double number, const std::string& unit, const Dimension& dimension) const {
  double factor = 0;
  if (!dimension.square.empty()) {
    const std::string square = square_of(unit);
    factor = square.empty() ? 0 : std::sqrt(factor_to(system_.get(), square, dimension.square));
  } else if (dimension.exponent != std::floor(dimension.exponent)) {
    // UDUNITS has integer powers only: parse "<stress>^<exponent> <time>" in parts.
    const auto caret = unit.find('^');
    double exponent = 0;
    const char* const end = unit.data() + unit.size();
    if (caret != std::string::npos) {
      const auto [rest, status] = std::from_chars(unit.data() + caret + 1, end, exponent);
      const std::string before(trimmed(std::string_view(unit).substr(0, caret)));
      const std::string after(trimmed({rest, static_cast<std::size_t>(end - rest)}));
      const double stress = factor_to(system_.get(), before, "Pa");
      const double time = factor_to(system_.get(), after, "s");
      const bool matches = status == std::errc{} && std::abs(exponent - dimension.exponent) < 1e-12;
      factor = matches ? std::pow(stress, dimension.exponent) * time : not_a_number;
    } else {
      factor = looks_like_unit(unit) ? not_a_number : 0;
    }
  } else if (dimension.si_unit == "1" && unit != "%" && unit != "percent") {
    // UDUNITS counts angles as numbers, too. Draws of shares have the unit "1".
    factor = unit == "1" ? 1 : looks_like_unit(unit) ? not_a_number : 0;
  } else {
    factor = factor_to(system_.get(), unit, dimension.si_unit);
  }
  if (factor == 0) return {0, QuantityError::unknown_unit, unit};
  if (std::isnan(factor)) return {0, QuantityError::wrong_dimension, unit};
  const double value = number * factor;
  if (!std::isfinite(value)) return {0, QuantityError::not_finite, unit};
  return {value, QuantityError::none, unit};
}

const UnitSystem& UnitSystem::shared() {
  static const UnitSystem units;
  return units;
}

Quantity UnitSystem::read(const std::string& text, const Dimension& dimension) const {
  const std::string plain = plain_text(text);
  std::string_view rest = trimmed(plain);
  if (rest.size() > 1 && rest[0] == '+' && rest[1] != '-') rest.remove_prefix(1);
  double number = 0;
  const auto [end, status] = std::from_chars(rest.data(), rest.data() + rest.size(), number);
  if (status == std::errc::invalid_argument) return {0, QuantityError::no_number, {}};
  rest.remove_prefix(static_cast<std::size_t>(end - rest.data()));
  const std::string unit(trimmed(rest));
  if (status == std::errc::result_out_of_range || !std::isfinite(number)) {
    return {0, QuantityError::not_finite, unit};
  }
  if (unit.empty()) return {0, QuantityError::no_unit, unit};
  return convert(number, unit, dimension);
}

}  // namespace crackle::input
