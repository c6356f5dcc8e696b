// SPDX-License-Identifier: GPL-3.0-or-later
#include "common/checksum.h"
#include "common/text_table.h"
#include "input/reader.h"

#include "schema.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <map>
#include <string_view>

namespace crackle::input {

namespace {

/// Names of keys in identities, which stay those of version 1.0.0.
constexpr std::array<std::array<std::string_view, 2>, 2> names_in_identities{
    {{"mesh.symmetry", "mesh.turn"}, {"fracture.accumulation", "fracture.memory"}}};

/// The effect of a key in this input.
Affects affects_in(const Parameters& parameters, const Key& key, std::size_t i) {
  const bool has_layers =
      !parameters.random.empty() && parameters.ensemble.plan == SamplingPlan::latin_hypercube;
  if (key.affects == Affects::layers) return has_layers ? Affects::draws : Affects::run;
  if (key.affects != Affects::place) return key.affects;
  return parameters.boundaries.at(i).region == plane::everywhere ? Affects::conditions : Affects::points;
}

/// The keys with what they affect.
std::vector<std::pair<NamedValue, Affects>> resolved(const Parameters& parameters) {
  Parameters shown = parameters;
  std::vector<std::pair<NamedValue, Affects>> lines;
  const auto add_lines = [&](const Table& table, const std::string& path, std::size_t i) {
    for (const Key& key : table.keys)
      if (const auto text = key.show(shown, i))
        lines.push_back({{path + "." + key.name, *text}, affects_in(parameters, key, i)});
  };
  const bool has_list = is_list(parameters.materials);
  for (const Table& table : schema()) {
    if (has_list && table.part_of == "material") continue;
    for (std::size_t i = 0; i < (table.count ? table.count(shown) : 1); ++i) {
      const bool is_one_of_many =
          table.occurrence == Occurrence::many || (has_list && table.path == "material");
      add_lines(table, is_one_of_many ? numbered(table.path, table.path, i) : table.path, i);
      if (!has_list || table.path != "material") continue;
      for (const Table& part : schema())
        if (part.part_of == table.path) add_lines(part, numbered(part.path, table.path, i), i);
    }
  }
  return lines;
}

/// The accepted values of a key, in short: an example, where there is one, shows form, dimension and unit.
std::string short_form(const std::string& accepted) {
  constexpr std::string_view such_as = "such as ", number = "a number ";
  if (const std::size_t example = accepted.find(such_as); example != std::string::npos)
    return "e.g. " + accepted.substr(example + such_as.size());
  return accepted.starts_with(number) ? accepted.substr(number.size()) : accepted;
}

/// The text of a key in the list of keys, after its name.
std::string description(const Key& key) {
  const Requirement& requirement = key.requirement;
  constexpr std::string_view as_in = "as in ";
  if (requirement.unset.starts_with("as in ["))
    return fmt::format("(as in `{}`)", requirement.unset.substr(as_in.size()));
  const std::string unset = !requirement.instead.empty()
                                ? fmt::format("required, or `{}`", fmt::join(requirement.instead, "` or `"))
                            : requirement.required         ? "required"
                            : requirement.fallback.empty() ? requirement.unset
                                                           : fmt::format("`{}`", requirement.fallback);
  return fmt::format("({}): {}; {}", unset, short_form(key.accepted), key.help);
}

}  // namespace

Affects affects(const std::string& path) {
  return find_key(path)->affects;
}

bool affects(const RandomInput& random, std::initializer_list<Affects> any) {
  return std::ranges::any_of(keys_of(random), [&](const std::string& key) {
    return std::ranges::find(any, affects(key)) != any.end();
  });
}

std::string echo(const Parameters& parameters) {
  std::vector<NamedValue> lines;
  for (const auto& [line, affected] : resolved(parameters)) lines.push_back(line);
  return aligned(lines);
}

std::vector<std::string> sample_settings(const Parameters& parameters) {
  if (parameters.draw) return parameters.draw->settings;
  std::vector<std::string> settings;
  for (const auto& [line, affected] : resolved(parameters))
    if (affected != Affects::run) settings.push_back(fmt::format("{} = {}", line.first, line.second));
  return settings;
}

std::vector<std::string> settings_of(const Parameters& parameters, std::initializer_list<Affects> affected) {
  std::vector<std::string> settings;
  const auto add_file = [&](Affects what, const char* key, const std::string& digest) {
    if (!digest.empty() && std::ranges::find(affected, what) != affected.end())
      settings.push_back(fmt::format("{} with digest {}", key, digest));
  };
  add_file(Affects::body, "specimen.solid", solid::digest_of(parameters.specimen.solid));
  for (const auto& [line, affects] : resolved(parameters))
    if (std::ranges::find(affected, affects) != affected.end())
      settings.push_back(fmt::format("{} = {}", line.first, line.second));
  add_file(Affects::points, "mesh.points", parameters.mesh.points_digest);
  return settings;
}

std::string same_bits(Engine engine) {
  return engine == Engine::petsc ? "on the same number of ranks only" : "on any number of ranks";
}

std::string bits_notice(Engine engine) {
  if (engine == Engine::fixed_point) return {};
  return fmt::format("engine {}: a sample has the same bits {}", to_string(engine), same_bits(engine));
}

std::string sample_identity(const Parameters& parameters) {
  std::vector<std::string> settings = sample_settings(parameters);
  // Files that predate these keys have the samples of their defaults.
  for (const char* const setting : {"mesh.base = shared", "time.engine = fixed-point"})
    std::erase(settings, setting);
  for (std::string& setting : settings)
    for (const auto& [key, key_of_1_0] : names_in_identities)
      if (setting.starts_with(fmt::format("{} =", key))) setting.replace(0, key.size(), key_of_1_0);
  return fmt::format("FNV-1a {:016x}", checksum(fmt::format("{}", fmt::join(settings, "\n"))));
}

std::string key_list() {
  std::string result;
  std::map<std::string, std::string> known;  // tables by name and description of their keys
  for (const Table& table : schema()) {
    const char* occurrence = table.occurrence == Occurrence::many ? ", any number"
                             : table.occurrence == Occurrence::once_or_many
                                 ? ", or `[[material]]`, each with a name"
                             : table.occurrence == Occurrence::optional ? ", optional"
                                                                        : "";
    result += fmt::format("{}**`{}`**{}: {}\n\n", result.empty() ? "" : "\n", header_of(table), occurrence,
                          table.help);
    std::map<std::string, std::string> repeated;  // names of keys by the earlier table that has them
    for (std::size_t i = 0; i < table.keys.size(); ++i) {
      const Key& key = table.keys[i];
      const auto [entry, is_new] = known.emplace(key.name + description(key), header_of(table));
      if (!is_new) {
        std::string& names = repeated[entry->second];
        names += fmt::format("{}`{}`", names.empty() ? "" : ", ", key.name);
        continue;
      }
      std::string names = fmt::format("`{}`", key.name);
      // Keys that differ in their names only, such as the extents along three axes, share an entry.
      for (; i + 1 < table.keys.size() && description(table.keys[i + 1]) == description(key); ++i)
        names += fmt::format(", `{}`", table.keys[i + 1].name);
      result += fmt::format("- {} {}\n", names, description(key));
    }
    for (const auto& [earlier, names] : repeated)
      result += fmt::format("- {} (as in `{}`)\n", names, earlier);
  }
  return result;
}

}  // namespace crackle::input
