// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "input/parameters.h"

#include <filesystem>
#include <initializer_list>
#include <memory>
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

/// Files that replace those named by an input.
struct GivenFiles {
  std::filesystem::path points = {};  ///< empty: the file named by mesh.points
  std::string points_digest = {};     ///< of its contents if already known; the file is then not read
  std::filesystem::path solid = {};   ///< empty: the file named by specimen.solid
  std::shared_ptr<const solid::Solid> known_solid = {};  ///< if already known; the file is then not read
};

/// Those of other parameters of the same input.
GivenFiles files_of(const Parameters& parameters);

/// Reads and validates an input file: syntax, units, dimensions, ranges, unknown and missing keys, and
/// contradictions between keys (a notch outside the body, overlapping notches, a section that no crack can
/// reach). Relative file names in the input are relative to the input file.
/// @throws InputError with every error of the file
Parameters read(const std::filesystem::path& file, const GivenFiles& files = {});

/// As read(), for a text in memory; `name` is used as the file name in messages.
Parameters parse(const std::string& text, const std::filesystem::path& name, const GivenFiles& files = {});

/// A replacement for a value of an input.
struct Setting {
  std::string key;    ///< "fracture.release", "specimen.notch[0].depth"
  std::string value;  ///< in TOML
  bool operator==(const Setting&) const = default;
};

/// The text of an input with other values, preserving comments and order. Missing keys are added to their
/// tables.
/// @throws InputError when a value cannot be placed: in a list that is too short, or in a missing table
std::string with_settings(const std::string& text, const std::vector<Setting>& settings);

/// The text of an input with values for those of the keys that it leaves out. A text that is not TOML stays.
/// @throws InputError as with_settings
std::string completed(const std::string& text, std::vector<Setting> settings);

/// The parameters with other values, read and validated again as those of a draw; `text` is unchanged.
/// @param name used as the file name in messages
/// @throws InputError with every error
Parameters drawn(const Parameters& parameters, const std::vector<double>& values, const std::string& name);

/// One case of a sweep.
struct Case {
  std::vector<Setting> settings;
  Parameters parameters;  ///< a separate input, without [[sweep]]
};

/// All combinations of the sweeps' values; the last sweep varies fastest.
/// @param name used as the file name in messages
/// @throws InputError with every error of the first invalid case, naming the case
/// @param are_stored of results, whose rasters need not be there any more
std::vector<Case> sweep_cases(const Parameters& parameters, const std::filesystem::path& name,
                              bool are_stored = false);

/// One line for each group of identical cases: equal values of all keys give equal samples.
std::vector<std::string> sweep_warnings(const std::vector<Case>& cases);

/// "mesh.perturbation = 0.1, fracture.release = \"facet\""
std::string to_string(const std::vector<Setting>& settings);

/// The same input with other sections, for results at sections other than those of the run; `text` is
/// unchanged.
/// @param given at least one "y=7 mm, 9 mm", "z=30 mm" or "line=1 mm, 2 mm; 3 mm, 4 mm" (y, z of a line's
///   ends), read and validated like the keys of [sections]; those of one axis are combined
/// @param name used as the file name in messages
/// @throws InputError with every error
Parameters with_sections(Parameters parameters, const std::vector<std::string>& given,
                         const std::string& name);

/// Sections as with_sections() takes them, in a shell: y="7 mm, 9 mm"
std::vector<std::string> as_given(const Sections& sections);

/// The keys of all numbers that change: its own, then those that change with it.
std::vector<std::string> keys_of(const RandomInput& random);

/// A random input's distribution with its given parameters, as "normal, mean 3.3 GPa, standard deviation 0.2
/// GPa".
std::string describe(const RandomInput& random);

/// A value of a random input with a readable unit.
std::string format_value(const RandomInput& random, double value);

/// A value with its unit, such as "500 N".
/// @param si_unit unit of the result; "" or "1" for dimensionless numbers
/// @throws std::runtime_error when the text is not such a value
double read_value(const std::string& text, const std::string& si_unit);

/// The effect of a key of the input.
enum class Affects {
  run,         ///< how samples are computed and how many, but none of them
  layers,      ///< the draws if they are in the layers of a Latin hypercube, otherwise the run
  draws,       ///< the draws of the random inputs
  body,        ///< its shape
  points,      ///< the base mother points
  place,       ///< where a condition acts: its region changes the points; without one, the sample
  mesh,        ///< what a sample makes of the points
  materials,   ///< to which material or interface the tetrahedra belong, and their factors
  conditions,  ///< what acts on the body
  sample,      ///< what else happens in the mesh
  records,     ///< what is stored of it
  reading      ///< what is read off what is stored
};

/// The effect of the key at a path such as "boundary[1].rate[2]". @pre the schema has it
Affects affects(const std::string& path);

/// True if a random input, or a number that moves with it, affects one of these.
bool affects(const RandomInput& random, std::initializer_list<Affects> any);

/// The resolved input, one "key = value unit" line for each key, including defaults.
std::string echo(const Parameters& parameters);

/// The lines of echo() that determine a sample's results: all but those that affect the run only.
std::vector<std::string> sample_settings(const Parameters& parameters);

/// The lines of echo() with keys that affect one of these, and the digests of the files that do.
std::vector<std::string> settings_of(const Parameters& parameters, std::initializer_list<Affects> affected);

/// Checksum of sample_settings(), as text: inputs with equal checksums have the same samples.
std::string sample_identity(const Parameters& parameters);

/// Under which conditions samples of an engine are bitwise equal: "on any number of ranks".
std::string same_bits(Engine engine);

/// The corresponding line of a log; empty for the default engine.
std::string bits_notice(Engine engine);

/// The input with all missing keys added as comments, in the order of the schema: "#seed = 0" after lines "#
/// meaning: what is accepted". Existing content is unchanged; the text still describes the same input.
/// @param text a valid input
std::string annotated(const std::string& text);

/// All keys in Markdown, a list for each table: name, default or whether it is required, accepted values,
/// meaning.
std::string key_list();

}  // namespace crackle::input
