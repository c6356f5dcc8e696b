// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "crackle/input/parameters.h"

#include <filesystem>
#include <stdexcept>
#include <string>
#include <utility>
#include <vector>

namespace crackle::input {

/// All errors of an input file. what() has one line for each: "file:line: key: what is wrong; what is
/// accepted".
class InputError : public std::runtime_error {
public:
  explicit InputError(std::vector<std::string> messages);
  const std::vector<std::string>& messages() const { return messages_; }

private:
  std::vector<std::string> messages_;
};

/// The file of mother points, where another one stands for the file that mesh.points names.
struct PointsFile {
  std::filesystem::path path;  ///< empty: the file that mesh.points names
  std::string digest;          ///< of its content, when that is known already; then it is not looked at
};

/// Reads and validates an input file: syntax, units, dimensions, ranges, unknown and missing keys, and
/// contradictions between keys (a notch outside the body, overlapping notches, a section that no crack can
/// reach). Relative file names in the input are relative to the input file.
/// @throws InputError with every error of the file
Parameters read(const std::filesystem::path& file, const PointsFile& points = {});

/// As read(), for a text already in memory; `name` stands for the file in messages.
Parameters parse(const std::string& text, const std::filesystem::path& name, const PointsFile& points = {});

/// A value in place of the one that an input has.
struct Setting {
  std::string key;    ///< "fracture.release", "specimen.notch[0].depth"
  std::string value;  ///< in TOML
  bool operator==(const Setting&) const = default;
};

/// The text of an input with other values; comments and order stay. A key that the text does not have is
/// added to its table.
/// @throws InputError when a value has no place: of a list that is too short, or in a table that is missing
std::string with_settings(const std::string& text, const std::vector<Setting>& settings);

/// The parameters with other values, read and judged anew, as those of a draw: `text` stays.
/// @param name stands for the file in messages
/// @throws InputError with every error
Parameters drawn(const Parameters& parameters, const std::vector<double>& values, const std::string& name);

/// One case of a sweep.
struct Case {
  std::vector<Setting> settings;
  Parameters parameters;  ///< an input of its own, without [[sweep]]
};

/// All combinations of the sweeps' values; the last sweep changes fastest.
/// @param name stands for the file in messages
/// @throws InputError with every error of the first case that has any, naming the case
std::vector<Case> sweep_cases(const Parameters& parameters, const std::filesystem::path& name);

/// One line for each group of equal cases: with the same value of every key, the same samples.
std::vector<std::string> sweep_warnings(const std::vector<Case>& cases);

/// "mesh.perturbation = 0.1, fracture.release = \"facet\""
std::string to_string(const std::vector<Setting>& settings);

/// The same input with other sections, for results at sections that it was not computed with; `text` stays.
/// @param given at least one "y=7 mm, 9 mm", "z=30 mm" or "line=1 mm, 2 mm; 3 mm, 4 mm" (y, z of a line's
/// ends), read and judged as the keys of [sections]; those of one axis are put together
/// @param name stands for the file in messages
/// @throws InputError with every error
Parameters with_sections(Parameters parameters, const std::vector<std::string>& given,
                         const std::string& name);

/// A random input's distribution and the parameters of it that are given, as "normal, mean 3.3 GPa, standard
/// deviation 0.2 GPa".
std::string describe(const RandomInput& random);

/// A value of a random input with its unit, as people read it.
std::string format_value(const RandomInput& random, double value);

/// A value with its unit, such as "500 N".
/// @param si_unit unit of the result; "" and "1" for plain numbers
/// @throws std::runtime_error for a text that is no such value
double read_value(const std::string& text, const std::string& si_unit);

/// Key or name, and value.
using Line = std::pair<std::string, std::string>;
/// "name = value" for each line, values under each other.
std::string aligned(const std::vector<Line>& lines);

/// The resolved input, one "key = value unit" line for each key, defaults included.
std::string echo(const Parameters& parameters);

/// The lines of echo() that a sample's results follow from: all but the number of samples, the rule to stop
/// early, the ranks that share a sample, and the name of the points' file.
std::vector<std::string> sample_settings(const Parameters& parameters);

/// Those that the meshed bodies follow from: specimen, mesh, and the regions that conditions hold on.
std::vector<std::string> body_settings(const Parameters& parameters);

/// Check sum of sample_settings(), as text: two inputs with the same one have the same samples.
std::string sample_identity(const Parameters& parameters);

/// In which runs a sample of an engine has the same bits: "on any number of ranks".
std::string same_bits(Engine engine);

/// The line of a log that says so; empty for the default engine.
std::string bits_notice(Engine engine);

/// An input with every key that it does not give as a comment, in the order of the schema: "#seed = 0" after
/// lines "# meaning: what is accepted". What the input gives stays as it is; the text is still that input.
/// @param text a sound input
std::string annotated(const std::string& text);

/// The table of all keys in Markdown: key, dimension, default, accepted range, meaning.
std::string key_table();

}  // namespace crackle::input
