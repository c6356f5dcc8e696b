// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "dimension.h"
#include "document.h"
#include "findings.h"
#include "input/reader.h"
#include "units.h"

#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

/// Typed values from a document: each function either returns an accepted value, or reports the error and
/// returns nothing.
namespace crackle::input {

struct Context {
  const UnitSystem& units;
  Findings& findings;
  std::filesystem::path folder;  ///< base of relative file names
  const GivenFiles& files;
  const Value* root = nullptr;  ///< the whole document; may be null
};

/// A value with its name in messages.
struct Source {
  const Value& value;
  std::string key;
  Context& context;

  /// @return nullopt, for use in return statements
  std::nullopt_t report(const std::string& message) const {
    context.findings.report(key, value.line, message);
    return std::nullopt;
  }
  template <class... Arguments>
  std::nullopt_t report(fmt::format_string<Arguments...> message, Arguments&&... arguments) const {
    return report(fmt::format(message, std::forward<Arguments>(arguments)...));
  }
};

/// An interval of accepted values, in SI units.
struct Range {
  double lower;
  double upper;
  bool lower_open = false;
  bool upper_open = false;

  bool contains(double value) const {
    return (lower_open ? value > lower : value >= lower) && (upper_open ? value < upper : value <= upper);
  }
};

/// "length" of "a length".
std::string name_without_article(const Dimension& dimension);

/// "a length such as "1.0 mm"".
std::string quantity_form(const Dimension& dimension);
/// "a length above 0 and up to 1 m, such as "1.0 mm"", "a number from 0 to 0.5".
std::string accepted(const Dimension& dimension, const Range& range);
std::string accepted_number(const Range& range);
std::string accepted_integer(std::int64_t lower, std::int64_t upper);
std::string accepted_choice(const std::vector<std::string>& names);

std::optional<double> read_quantity(const Source& source, const Dimension& dimension, const Range& range);
std::optional<double> read_number(const Source& source, const Range& range);
std::optional<std::int64_t> read_integer(const Source& source, std::int64_t lower, std::int64_t upper);
std::optional<std::string> read_text(const Source& source, const std::string& accepted);

/// A text of up to 60 characters that may name a group in a file.
/// @param example as in "gauge"
std::string accepted_name(const std::string& example);
std::optional<std::string> read_name(const Source& source, const std::string& example);

/// Index of the string in `names`.
std::optional<std::size_t> read_choice(const Source& source, const std::vector<std::string>& names);

/// The elements of an array.
/// @param count required number; 0: at least one
std::optional<std::vector<Source>> read_elements(const Source& source, std::size_t count,
                                                 const std::string& accepted);

}  // namespace crackle::input
