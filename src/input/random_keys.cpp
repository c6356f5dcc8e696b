// SPDX-License-Identifier: GPL-3.0-or-later
// [[random]]: numbers of the input that vary between samples.
#include "consistency.h"
#include "schema.h"

#include "common/index.h"
#include "common/printable.h"
#include "common/quantity_text.h"
#include "input/copula.h"

#include <array>
#include <charconv>
#include <cmath>
#include <filesystem>
#include <fstream>
#include <set>

namespace crackle::input {

namespace {

constexpr Range any{-1e300, 1e300};

struct Parameter {
  const char* name;
  double RandomInput::*member;
  const char* help;
  std::vector<std::string> synonyms;
};

const std::array parameters_of_random{
    Parameter{"mean", &RandomInput::mean, "of truncated, before truncation", {"mu", "average"}},
    Parameter{"standard_deviation",
              &RandomInput::standard_deviation,
              "of truncated, before truncation",
              {"sigma", "std", "sd", "stddev"}},
    Parameter{"lower", &RandomInput::lower, "smallest and largest value", {"min", "a"}},
    Parameter{"upper", &RandomInput::upper, "smallest and largest value", {"max", "b"}},
    Parameter{"mode", &RandomInput::mode, "of triangular", {"c"}},
    Parameter{"scale", &RandomInput::scale, "of weibull, measured from lower", {"lambda"}},
};
const Parameter shape_parameter{"shape", &RandomInput::shape, "modulus of weibull", {"k", "m", "modulus"}};

/// The parameters of a distribution, by key.
struct Signature {
  std::vector<std::string_view> required;
  std::vector<std::string_view> optional;
};

const Signature& signature_of(RandomDistribution distribution) {
  static const std::array<Signature, distribution_names.size()> signatures{
      Signature{{"standard_deviation"}, {"mean"}},
      Signature{{"standard_deviation"}, {"mean", "lower"}},
      Signature{{"lower", "upper"}, {}},
      Signature{{"lower", "upper"}, {"mean", "mode"}},
      Signature{{"shape", "scale"}, {"lower"}},
      Signature{{"lower", "upper", "standard_deviation"}, {"mean"}},
      Signature{{"standard_deviation"}, {"mean", "lower", "upper"}},
      Signature{{"values"}, {"weights"}},
      Signature{{"values"}, {}}};
  return signatures[static_cast<std::size_t>(distribution)];
}

bool contains(const std::vector<std::string_view>& names, std::string_view name) {
  return std::ranges::find(names, name) != names.end();
}

/// The dimension of a random input's values. @pre it has a unit
Dimension dimension_of(const RandomInput& random) {
  if (random.exponent != 0) return impulse_dimension(random.exponent);
  for (const Dimension& dimension : known_dimensions(0))
    if (dimension.si_unit == random.unit) return dimension;
  throw std::logic_error("no key has the unit " + random.unit);
}

constexpr std::array without_random{"ensemble", "sections", "output", "random", "correlation", "sweep"};

const std::string accepted_random_key =
    "a number that the input gives, such as \"material.youngs_modulus\" or \"specimen.notch[0].depth\", or "
    "an "
    "array of them that change together";

/// The path under which an input gives what it does not give under this one.
std::optional<std::string> given_instead(const Value& root, const std::string& path) {
  std::vector<std::string> others;
  if (path == "specimen.thickness") others.emplace_back("specimen.size[0]");
  const std::string table = path.substr(0, path.rfind('.') + 1), name = path.substr(table.size());
  if (name == "toughness") others.push_back(table + "fracture_toughness");
  if (name == "fracture_toughness") others.push_back(table + "toughness");
  // The first of several tables.
  for (auto dot = path.find('.'); dot != std::string::npos; dot = path.find('.', dot + 1))
    others.push_back(path.substr(0, dot) + "[0]" + path.substr(dot));
  for (const std::string& other : others)
    if (find_path(root, other) != nullptr) return other;
  return {};
}

/// Finds the number that a text names. Its key stays empty if there is none, which is reported.
RandomInput named_number(const Source& source, double exponent) {
  RandomInput random;
  const auto path = read_text(source, accepted_random_key);
  if (!path) return random;
  const std::string shown = shortened(*path);
  const Key* const key = find_key(*path);
  if (key == nullptr) {
    source.report("the input has no key \"{}\"; {}", shown, advice_on_key(*path, accepted_random_key));
    return random;
  }
  for (const std::string_view table : without_random) {
    if (!path->starts_with(table)) continue;
    const char next = (*path)[table.size()];
    if (next != '.' && next != '[') continue;
    source.report("keys of [{}] cannot be random; give {}", table, accepted_random_key);
    return random;
  }
  const Value* const value = source.context.root ? find_path(*source.context.root, *path) : nullptr;
  if (value == nullptr) {
    const auto instead = source.context.root ? given_instead(*source.context.root, *path) : std::nullopt;
    source.report("the input does not give \"{}\"; {}", shown,
                  instead ? fmt::format("did you mean \"{}\"?", *instead) : "give its nominal value");
    return random;
  }
  random.key = *path;
  const bool plain = value->kind == ValueKind::number || value->kind == ValueKind::integer;
  if (plain && key->dimension != "integer") {
    random.own = value->number;
    return random;
  }
  if (value->kind == ValueKind::string) {
    std::vector<Dimension> dimensions = known_dimensions(exponent);
    // A rate in 1/s could also be an angular velocity. (Not of std::ranges, whose subranges of GCC 12 are
    // beyond clang 14.)
    std::stable_partition(dimensions.begin(), dimensions.end(),
                          [&](const Dimension& one) { return one.name.ends_with(" " + key->dimension); });
    for (const Dimension& dimension : dimensions) {
      const Quantity quantity = source.context.units.read(value->string, dimension);
      if (quantity.error != QuantityError::none) continue;
      random.unit = dimension.si_unit;
      random.own = quantity.value;
      random.exponent = dimension.exponent;
      return random;
    }
  }
  source.report("\"{}\" is {}, not a number that can be random; give {}", shown,
                is_plain(*value) && value->kind != ValueKind::array ? to_toml(*value) : describe(value->kind),
                accepted_random_key);
  return random;
}

/// Finds the numbers of the key.
void resolve(const Source& source, RandomInput& random, double exponent) {
  if (source.value.kind != ValueKind::array) {
    random = named_number(source, exponent);
    return;
  }
  const auto names = read_elements(source, 0, accepted_random_key);
  if (!names) return;
  for (const Source& name : *names) {
    RandomInput number = named_number(name, exponent);
    if (&name == &names->front())
      random = std::move(number);
    else
      random.moved.push_back({std::move(number.key), number.own, std::move(number.unit)});
  }
}

Key random_key_key() {
  return {"key",
          "name, or names",
          required(),
          accepted_random_key,
          "entries are counted from 0; keys of the geometry need mesh.base = \"own\"; of several names the "
          "distribution is that of the first",
          [](const Source& source, Parameters& parameters, std::size_t i) {
            resolve(source, parameters.random.at(i), parameters.fracture.exponent);
          },
          [](Parameters& parameters, std::size_t i) {
            const RandomInput& random = parameters.random.at(i);
            return random.moved.empty() ? random.key : bracketed(keys_of(random));
          }};
}

Key distribution_key() {
  std::vector<std::pair<std::string, RandomDistribution>> choices;
  for (std::size_t i = 0; i < distribution_names.size(); ++i)
    choices.emplace_back(distribution_names[i], static_cast<RandomDistribution>(i));
  return choice_key<RandomDistribution>(
      "distribution",
      [](Parameters & parameters, std::size_t i) -> auto& { return parameters.random.at(i).distribution; },
      choices, required(),
      "uniform takes lower and upper; triangular these and mean or mode; beta these and standard_deviation; "
      "normal takes standard_deviation; truncated (normal) this and lower, upper or both; lognormal takes "
      "standard_deviation, weibull shape and scale, each with lower if it does not start at 0; discrete and "
      "empirical take values");
}

Key together_key() {
  const auto by_factor = [](Parameters& parameters, std::size_t i) -> bool& {
    return parameters.random.at(i).by_factor;
  };
  Key key = choice_key<bool>(
      "together", by_factor, {{"amount", false}, {"factor", true}}, by_default("\"amount\""),
      "how several keys change with the first: all by the same amount, or by the same factor");
  key.show = [=](Parameters& parameters, std::size_t i) -> std::optional<std::string> {
    if (!by_factor(parameters, i)) return {};
    return "factor";
  };
  return key;
}

constexpr std::size_t most_values = 10'000;
const std::string accepted_values =
    "values of the key, such as [\"3 mm\", \"4 mm\"], or the name of a text file with one on each line";

std::optional<double> value_of(const Source& source, const RandomInput& random) {
  return random.unit.empty() ? read_number(source, any) : read_quantity(source, dimension_of(random), any);
}

/// The lines of a file, as elements of an array; # begins a comment.
std::optional<Value> lines_of(const Source& source, const RandomInput& random) {
  const std::filesystem::path file = source.context.folder / source.value.string;
  const std::string name = shortened(file.string(), 200);
  std::error_code error;
  if (!std::filesystem::is_regular_file(file, error))
    return source.report("there is no file \"{}\"; give {}", name, accepted_values);
  std::ifstream stream(file);
  Value all;
  all.kind = ValueKind::array;
  all.line = source.value.line;
  std::string text;
  for (int line = 1; std::getline(stream, text); ++line) {
    if (line == 1) text = without_mark(text);
    text = trimmed(text.substr(0, text.find('#')));
    if (text.empty()) continue;
    Value value;
    value.kind = ValueKind::string;
    value.line = source.value.line;
    value.string = text;
    if (random.unit.empty()) {
      value.kind = ValueKind::number;
      const auto [end, fault] = std::from_chars(text.data(), text.data() + text.size(), value.number);
      if (fault != std::errc() || end != text.data() + text.size())
        return source.report("{}:{}: not a number", name, line);
    } else if (source.context.units.read(text, dimension_of(random)).error != QuantityError::none) {
      return source.report("{}:{}: \"{}\" is not {}", name, line, shortened(text),
                           quantity_form(dimension_of(random)));
    }
    all.elements.push_back(std::move(value));
  }
  return all;
}

Key values_key() {
  return {
      "values",
      "as the key",
      optional("by distribution"),
      accepted_values,
      "of discrete and empirical; empirical is linear between them",
      [](const Source& source, Parameters& parameters, std::size_t i) {
        RandomInput& random = parameters.random.at(i);
        if (random.key.empty()) return;
        std::optional<Value> read;
        if (source.value.kind == ValueKind::string && !(read = lines_of(source, random))) return;
        const Value& given = read ? *read : source.value;
        const auto elements = read_elements(Source{given, source.key, source.context}, 0, accepted_values);
        if (!elements) return;
        for (const Source& element : *elements) {
          const auto value = value_of(element, random);
          if (!value) return;
          random.values.push_back(*value);
        }
        std::size_t size = 0;  // in the stored input, which holds them all
        for (const double value : random.values)
          size += fmt::formatted_size("\"{} {}\", ", value, random.unit);
        if (random.values.size() > most_values)
          source.report("has {} values; give at most {}", random.values.size(), most_values);
        else if (size > max_text_size / 2)
          source.report(
              "has values that take {} bytes as text; give fewer than {}, by fewer values or digits", size,
              max_text_size / 2);
      },
      [](Parameters& parameters, std::size_t i) -> std::optional<std::string> {
        const RandomInput& random = parameters.random.at(i);
        if (random.values.empty()) return {};
        std::vector<std::string> shown;
        for (const double value : random.values) shown.push_back(format_value(random, value));
        return bracketed(shown);
      }};
}

Key weights_key() {
  const std::string form = "positive numbers, one for each of the values, such as [3, 1]";
  return {"weights",
          "numbers",
          optional("equal ones"),
          form,
          "of discrete",
          [=](const Source& source, Parameters& parameters, std::size_t i) {
            const auto elements = read_elements(source, 0, form);
            if (!elements) return;
            for (const Source& element : *elements) {
              const auto weight = read_number(element, {0, 1e9, true});
              if (!weight) return;
              parameters.random.at(i).weights.push_back(*weight);
            }
          },
          [](Parameters& parameters, std::size_t i) -> std::optional<std::string> {
            std::vector<std::string> shown;
            for (const double weight : parameters.random.at(i).weights)
              shown.push_back(format_number(weight));
            if (shown.empty()) return {};
            return bracketed(shown);
          }};
}

Key parameter_key(const Parameter& parameter) {
  const bool is_shape = parameter.member == &RandomInput::shape;
  const auto member = parameter.member;
  const std::string unset = member == &RandomInput::mean ? "the input's own value" : "by distribution";
  return {parameter.name,
          is_shape ? "number" : "as the key",
          optional(unset),
          is_shape ? accepted_number({0, 1e3, true}) : "a value of the key, such as \"165 MPa\"",
          parameter.help,
          [=](const Source& source, Parameters& parameters, std::size_t i) {
            RandomInput& random = parameters.random.at(i);
            if (random.key.empty()) return;
            const std::optional<double> value =
                is_shape ? read_number(source, {0, 1e3, true}) : value_of(source, random);
            if (value) random.*member = *value;
          },
          [=](Parameters& parameters, std::size_t i) -> std::optional<std::string> {
            const RandomInput& random = parameters.random.at(i);
            if (std::isnan(random.*member)) return {};
            return is_shape ? format_number(random.shape) : format_value(random, random.*member);
          },
          parameter.synonyms};
}

/// Checks that one distribution has the parameters that it takes. @return whether it has
bool check_presence(const RandomInput& random, const std::string& table, Findings& findings) {
  const Signature& signature = signature_of(random.distribution);
  const char* const name = distribution_names[static_cast<std::size_t>(random.distribution)];
  bool complete = true;
  const auto check = [&](std::string_view parameter) {
    const std::string key = table + "." + std::string(parameter);
    if (findings.faulty(key)) complete = false;
    const bool needed = contains(signature.required, parameter);
    if (needed && !findings.given(key)) {
      findings.report(key, "the key is missing; \"{}\" takes {}", name, fmt::join(signature.required, ", "));
      complete = false;
    } else if (!needed && !contains(signature.optional, parameter) && findings.given(key)) {
      findings.report(
          key, "\"{}\" does not take this key; it takes {}{}{}", name, fmt::join(signature.required, ", "),
          signature.optional.empty() ? "" : " and optionally ", fmt::join(signature.optional, ", "));
      complete = false;
    }
  };
  for (const Parameter& parameter : parameters_of_random) check(parameter.name);
  for (const char* const name_of : {shape_parameter.name, "values", "weights"}) check(name_of);
  return complete;
}

}  // namespace

bool has_own_mean(const RandomInput& random) {
  // The mean of triangular follows from its limits.
  return std::isnan(random.mean) && contains(signature_of(random.distribution).optional, "mean") &&
         random.distribution != RandomDistribution::triangular;
}

void check_distribution(const RandomInput& random, const std::string& table, Findings& findings) {
  if (!check_presence(random, table, findings)) return;
  const auto is_given = [](double value) { return !std::isnan(value); };
  const auto report = [&](const char* parameter, const std::string& message) {
    findings.report(table + "." + parameter, message);
  };
  const auto shown = [&](double value) { return format_value(random, value); };
  const double lower = random.lower, upper = random.upper, mean = random.mean;
  if (is_given(random.standard_deviation) && random.standard_deviation <= 0)
    return report("standard_deviation", "is not above 0");
  if (is_given(random.scale) && random.scale <= 0) return report("scale", "is not above 0");
  if (is_given(lower) && is_given(upper) && lower >= upper)
    return report("upper", fmt::format("{} is not above lower, {}", shown(upper), shown(lower)));
  const auto inside = [&](double value) {
    return !(is_given(lower) && value <= lower) && !(is_given(upper) && value >= upper);
  };
  const auto outside = [&](const char* what, double value) {
    return fmt::format("the {} {} is not between lower and upper", what, shown(value));
  };
  const double center = is_given(mean) ? mean : random.own;
  switch (random.distribution) {
    case RandomDistribution::lognormal: {
      const double start = is_given(lower) ? lower : 0;
      if (center <= start)
        report(is_given(mean) ? "mean" : "distribution",
               fmt::format("the mean {} is not above {}, the lower bound of lognormal", shown(center),
                           shown(start)));
      break;
    }
    case RandomDistribution::triangular:
      if (is_given(mean) && is_given(random.mode))
        report("mode", "both mean and mode are given; give one of them");
      else if (is_given(random.mode) && !(random.mode >= lower && random.mode <= upper))
        report("mode", outside("mode", random.mode));
      else if (is_given(mean) && !(3 * mean >= 2 * lower + upper && 3 * mean <= lower + 2 * upper))
        report("mean",
               fmt::format(
                   "no triangular distribution from {} to {} has the mean {}; give one in the middle third",
                   shown(lower), shown(upper), shown(mean)));
      break;
    case RandomDistribution::beta:
      if (!inside(center))
        report(is_given(mean) ? "mean" : "distribution", outside("mean", center));
      else if (std::pow(random.standard_deviation, 2) >= (center - lower) * (upper - center))
        report("standard_deviation",
               fmt::format("{} is too large for a mean of {} between {} and {}; give one below {}",
                           shown(random.standard_deviation), shown(center), shown(lower), shown(upper),
                           shown(std::sqrt((center - lower) * (upper - center)))));
      break;
    case RandomDistribution::truncated:
      if (!is_given(lower) && !is_given(upper))
        report("distribution", "\"truncated\" takes lower, upper or both; or give \"normal\"");
      else if (!inside(center))
        report(is_given(mean) ? "mean" : "distribution", outside("mean", center));
      break;
    case RandomDistribution::discrete:
      if (!random.weights.empty() && random.weights.size() != random.values.size())
        report("weights", fmt::format("there are {} for {}; give one for each", random.weights.size(),
                                      count_text(std::ssize(random.values), "value")));
      [[fallthrough]];
    case RandomDistribution::empirical:
      if (std::ranges::adjacent_find(random.values, std::ranges::not_equal_to{}) == random.values.end())
        report("values", "there is one value only, which cannot vary; give two different ones or more");
      break;
    case RandomDistribution::normal:
    case RandomDistribution::uniform:
    case RandomDistribution::weibull:
      break;
  }
}

Table random_table() {
  Table table{"random",
              Occurrence::many,
              "a number of the input that varies between samples",
              {random_key_key(), together_key(), distribution_key()},
              [](const Parameters& parameters) { return parameters.random.size(); },
              [](Parameters& parameters) { parameters.random.emplace_back(); }};
  for (const Parameter& parameter : parameters_of_random) table.keys.push_back(parameter_key(parameter));
  table.keys.push_back(parameter_key(shape_parameter));
  table.keys.push_back(values_key());
  table.keys.push_back(weights_key());
  return table;
}

Table correlation_table() {
  const std::string form =
      "the names of two random keys, such as [\"material.youngs_modulus\", \"fracture.toughness\"]";
  const auto at = [](Parameters& parameters, std::size_t i) -> RankCorrelation& {
    return parameters.correlations.at(i);
  };
  Key between = pair_key(
      [=](Parameters & parameters, std::size_t i) -> auto& { return at(parameters, i).between; }, form, form,
      "the first key of each [[random]]; others are independent");
  Key rank = number_key(
      "rank", [=](Parameters & parameters, std::size_t i) -> auto& { return at(parameters, i).rank; },
      {-1, 1, true, true}, required(), "Spearman's rank correlation, by a Gaussian copula");
  rank.accepted += ", such as 0.5";
  return {"correlation",
          Occurrence::many,
          "two random inputs that depend on each other",
          {std::move(between), std::move(rank)},
          [](const Parameters& parameters) { return parameters.correlations.size(); },
          [](Parameters& parameters) { parameters.correlations.emplace_back(); }};
}

std::vector<std::string> keys_of(const RandomInput& random) {
  std::vector<std::string> keys{random.key};
  for (const MovedNumber& moved : random.moved) keys.push_back(moved.key);
  return keys;
}

std::optional<std::string> parameter_instead_of(const std::string& key, const Parameters& parameters) {
  const auto random = std::ranges::find(parameters.random, key, &RandomInput::key);
  if (random == parameters.random.end()) return {};
  if (has_own_mean(*random)) return {};
  return fmt::format("random[{}].{}", random - parameters.random.begin(),
                     std::isnan(random->mean) ? signature_of(random->distribution).required.front() : "mean");
}

std::string format_value(const RandomInput& random, double value) {
  return random.unit.empty() ? format_number(value) : format_quantity(value, dimension_of(random));
}

std::string describe(const RandomInput& random) {
  std::string text = distribution_names[static_cast<std::size_t>(random.distribution)];
  const auto add = [&](const Parameter& parameter, const std::string& value) {
    std::string name = parameter.name;
    std::ranges::replace(name, '_', ' ');
    text += fmt::format(", {} {}", name, value);
  };
  for (const Parameter& parameter : parameters_of_random)
    if (!std::isnan(random.*parameter.member)) add(parameter, format_value(random, random.*parameter.member));
  if (!std::isnan(random.shape)) add(shape_parameter, format_number(random.shape));
  if (!random.values.empty()) text += fmt::format(", {}", count_text(std::ssize(random.values), "value"));
  for (const MovedNumber& moved : random.moved)
    text += fmt::format(", with {}{}", moved.key, random.by_factor ? " by the same factor" : "");
  return text;
}

namespace {

/// Checks the keys that change with the first one.
void check_moved(const RandomInput& random, const std::string& table, Findings& findings) {
  if (random.by_factor && random.moved.empty())
    findings.report(table + ".together",
                    "there is one key only; give an array of several, or leave this out");
  else if (random.by_factor && random.own == 0)
    findings.report(table + ".together", "\"{}\" is 0 in the input, which no factor changes", random.key);
  for (std::size_t k = 0; k < random.moved.size() && !random.by_factor; ++k)
    if (!random.moved[k].key.empty() && random.moved[k].unit != random.unit)
      findings.report(fmt::format("{}.key[{}]", table, k + 1),
                      "\"{}\" and \"{}\" have different units, so they cannot change by the same amount; "
                      "together = \"factor\" changes them by the same factor",
                      random.moved[k].key, random.key);
}

void check_correlations(const Parameters& parameters, Findings& findings) {
  std::set<std::set<std::string>> pairs;
  for (std::size_t i = 0; i < parameters.correlations.size(); ++i) {
    const std::string table = fmt::format("correlation[{}]", i);
    const auto& between = parameters.correlations[i].between;
    for (const std::string& key : between)
      if (!key.empty() &&
          std::ranges::find(parameters.random, key, &RandomInput::key) == parameters.random.end())
        findings.report(table + ".between", "\"{}\" is not the first key of a [[random]]", shortened(key));
    if (between[0] == between[1])
      findings.report(table + ".between", "both names are the same; give two");
    else if (!pairs.insert({between[0], between[1]}).second)
      findings.report(table + ".between", "this pair has a correlation already; give each once");
    if (findings.faulty(table + ".between") || findings.faulty(table + ".rank")) return;
  }
  if (!parameters.correlations.empty() && copula_factor(parameters).empty())
    findings.report("correlation[0].rank",
                    "no inputs have all these correlations at once: their matrix is not positive definite; "
                    "give smaller ones");
}

}  // namespace

void read_distribution(const Source& source, RandomInput& random) {
  Parameters scratch;
  scratch.random = {random};
  const std::vector<Key> keys = random_table().keys;
  for (const Member& member : source.value.members) {
    const auto key = std::ranges::find(keys, member.name, &Key::name);
    const Source value{member.value, source.key + "." + member.name, source.context};
    if (key == keys.end() || key->name == "key" || key->name == "together")
      value.report("unknown key; give distribution and its parameters, as in [[random]]");
    else
      key->read(value, scratch, 0);
  }
  if (source.value.find("distribution") == nullptr)
    source.context.findings.report(source.key + ".distribution", "the key is missing; give {}",
                                   accepted_choice({distribution_names.begin(), distribution_names.end()}));
  random = scratch.random.front();
}

std::string show_distribution(const RandomInput& random) {
  Parameters scratch;
  scratch.random = {random};
  std::vector<std::string> shown;
  for (const Key& key : random_table().keys)
    if (const auto text = key.name == "key" ? std::nullopt : key.show(scratch, 0))
      shown.push_back(key.name + " = " + *text);
  return fmt::format("{{{}}}", fmt::join(shown, ", "));
}

void check_random(const Parameters& parameters, Findings& findings) {
  std::set<std::string> keys;
  for (std::size_t i = 0; i < parameters.random.size(); ++i) {
    const RandomInput& random = parameters.random[i];
    const std::string table = fmt::format("random[{}]", i);
    if (random.key.empty() || findings.faulty(table + ".key")) continue;
    for (const std::string& key : keys_of(random)) {
      if (!keys.insert(key).second)
        findings.report(table + ".key", "\"{}\" is random already; give each key once", key);
      const bool moves_points = affects(key) == Affects::body || affects(key) == Affects::points;
      if (moves_points && parameters.mesh.base != Base::own)
        findings.report(table + ".key",
                        "\"{}\" changes the mother points, which all samples share; give mesh.base = \"own\"",
                        key);
    }
    check_moved(random, table, findings);
    if (!findings.faulty(table + ".distribution")) check_distribution(random, table, findings);
  }
  check_correlations(parameters, findings);
  if (parameters.ensemble.stop && parameters.ensemble.replicates > 1)
    findings.report("ensemble.stop",
                    "assumes independent samples, but samples of the same draw are not; leave it out, or "
                    "give ensemble.replicates = 1");
  if (!parameters.random.empty()) return;
  for (const char* const key : {"ensemble.plan", "ensemble.replicates"})
    if (findings.given(key) && !findings.given("random") && !findings.faulty(key))
      findings.report(key, "has no effect without [[random]]; add a [[random]] table, or leave it out");
}

}  // namespace crackle::input
