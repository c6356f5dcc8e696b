// SPDX-License-Identifier: GPL-3.0-or-later
// [material.map]: rasters of materials, stiffness or strength.
#include "common/checksum.h"
#include "common/quantity_text.h"
#include "consistency.h"
#include "schema.h"

#include <algorithm>
#include <system_error>

namespace crackle::input {

namespace {

MaterialMap& map(Parameters& parameters) {
  if (!parameters.map) parameters.map.emplace();
  return *parameters.map;
}

/// The key, hidden without a map, and read for one material only.
Key of_map(Key key) {
  key.read = [read = key.read](const Source& source, Parameters& parameters, std::size_t) {
    map(parameters);
    read(source, parameters, 0);
  };
  key.affects = Affects::materials;
  return shown_if(std::move(key), [](const Parameters& parameters, std::size_t i) {
    return parameters.map && i + 1 == parameters.materials.size();
  });
}

template <class T>
Access<T> of_the_map(T MaterialMap::*member) {
  return [=](Parameters& parameters, std::size_t) -> T& { return map(parameters).*member; };
}

Key file_key() {
  Key key =
      text_key("file", of_the_map(&MaterialMap::file), required(),
               "name of an HDF5 (.h5) or PNG (.png) file, relative to the input file, such as \"ct.png\" or "
               "\"ct-{sample}.h5\"",
               "the raster: one for all samples, or with {sample} one for each");
  key.read = [read = key.read](const Source& source, Parameters& parameters, std::size_t i) {
    read(source, parameters, i);
    map(parameters).folder = source.context.folder;
  };
  return key;
}

Key axes_key() {
  const std::vector<std::string> names{"x", "y", "z"};
  const std::string form = "one to three of \"x\", \"y\" and \"z\", such as [\"z\", \"y\"]";
  return {"axes",
          "words",
          required(),
          form,
          "in the order of the raster's dimensions (of a picture: rows, columns); constant along the others",
          [=](const Source& source, Parameters& parameters, std::size_t) {
            const auto elements = read_elements(source, 0, form);
            if (!elements) return;
            for (const Source& element : *elements)
              if (const auto axis = read_choice(element, names))
                map(parameters).axes.push_back(static_cast<int>(*axis));
          },
          [=](Parameters& parameters, std::size_t) {
            std::vector<std::string> axes;
            for (const int axis : map(parameters).axes) axes.push_back(names[static_cast<std::size_t>(axis)]);
            return bracketed(axes);
          }};
}

Key map_lengths_key(const char* name, const char* example, const char* help,
                    std::vector<double> MaterialMap::*member) {
  return lengths_key(name, of_the_map(member), fmt::format("a length for each of axes, such as {}", example),
                     coordinate, required(), help);
}

/// The checksum, which is computed if it is empty: the cases of a sweep have other files.
Key checksum_key() {
  Key key = text_key("checksum", of_the_map(&MaterialMap::checksum), optional("computed"),
                     R"(a text such as "198 bytes, FNV-1a 9ae16a3b2f90404f")",
                     "of the file, as the program writes it");
  key.read = [read = key.read](const Source& source, Parameters& parameters, std::size_t i) {
    const bool is_empty = source.value.kind == ValueKind::string && source.value.string.empty();
    if (!is_empty) read(source, parameters, i);
  };
  return key;
}

/// Stands in the stored input for the checksums of rasters of their own, which the sample files have.
constexpr const char* in_sample_files = "in the sample files";

/// Checks that the files are there.
/// @return their digest, or in_sample_files
std::optional<std::string> digest_of(const Parameters& parameters, Findings& findings) {
  const MaterialMap& map = *parameters.map;
  const auto n_files =
      static_cast<std::uint64_t>(map.has_file_per_sample() ? parameters.ensemble.samples : 1);
  for (std::uint64_t sample = 0; sample < n_files; ++sample) {
    std::error_code error;
    const std::filesystem::path file = map.path(sample);
    if (std::filesystem::is_regular_file(file, error)) continue;
    findings.report(map_key(parameters) + ".file",
                    "\"{}\" is not a readable file; give a name relative to the input file{}",
                    shortened(file.string(), 200),
                    map.has_file_per_sample() ? ", with files for all samples from 0 on" : "");
    return {};
  }
  if (map.has_file_per_sample()) return in_sample_files;
  const auto digest = file_digest(map.path(0));
  if (!digest) findings.report(map_key(parameters) + ".file", "\"{}\" cannot be read", map.file);
  return digest;
}

}  // namespace

Table map_table() {
  std::vector<Key> keys{
      file_key(),
      text_key("dataset", of_the_map(&MaterialMap::dataset), optional("required for HDF5"),
               "name of a dataset, such as \"/materials\"", "of an HDF5 file"),
      choice_key<MapOf>(
          "of", of_the_map(&MaterialMap::of),
          {{"material", MapOf::material},
           {"stiffness", MapOf::stiffness},
           {"strength", MapOf::strength},
           {"both", MapOf::stiffness_and_strength}},
          required(),
          "values: numbers of [[material]] tables, from 0, or factors of Young's modulus, strength, or both"),
      axes_key(),
      map_lengths_key("origin", R"(["0.05 mm", "0.05 mm"])", "middle of the first cell",
                      &MaterialMap::origin),
      map_lengths_key("spacing", R"(["0.1 mm", "0.1 mm"])",
                      "from one cell to the next; below 0 if coordinates descend", &MaterialMap::spacing),
      number_key("scale", of_the_map(&MaterialMap::scale), {0, 1e12, true}, by_default("1"),
                 "factor of the values; pictures have 0 to 255, or 65535"),
      checksum_key()};
  for (Key& key : keys) key = of_map(std::move(key));
  return {
      "material.map",
      Occurrence::optional,
      "a raster of the whole body, after the last [[material]], sampled at the centroids of the tetrahedra: "
      "boundaries between its cells are not meshed",
      std::move(keys),
      [](const Parameters& parameters) { return parameters.materials.size(); },
      {},
      "material"};
}

std::string map_key(const Parameters& parameters) {
  return material_key(parameters.materials, parameters.materials.size() - 1) + ".map";
}

void complete_map(Parameters& parameters, Findings& findings) {
  if (!parameters.map) return;
  MaterialMap& map = *parameters.map;
  const std::string table = map_key(parameters);
  if (!findings.given(table)) {
    findings.report("material", "give [material.map] once, after the last [[material]]");
    return;
  }
  if (findings.faulty(table)) return;
  for (const auto& [key, lengths] : {std::pair{"origin", &map.origin}, {"spacing", &map.spacing}})
    if (lengths->size() != map.axes.size())
      findings.report(fmt::format("{}.{}", table, key), "has {} for {}; give one for each",
                      count_text(lengths->size(), "length"),
                      map.axes.size() == 1 ? "1 axis" : fmt::format("{} axes", map.axes.size()));
  for (std::size_t k = 0; k < map.axes.size(); ++k)
    if (std::ranges::count(map.axes, map.axes[k]) > 1)
      return findings.report(table + ".axes", "names an axis twice");
  if (std::ranges::find(map.spacing, 0.0) != map.spacing.end())
    findings.report(table + ".spacing", "is 0; give the distance from one cell to the next");
  const std::string suffix = std::filesystem::path(map.file).extension().string();
  const bool is_hdf5 = suffix == ".h5" || suffix == ".hdf5";
  // A stored input may name what an earlier version has read.
  if (map.checksum.empty() && !is_hdf5 && suffix != ".png")
    findings.report(
        table + ".file",
        "\"{}\" has an unknown format; give a name that ends in .h5 or .png (of an array in Python: "
        "h5py.File(\"ct.h5\", \"w\")[\"ct\"] = numpy.load(\"ct.npy\"))",
        shortened(map.file));
  if (is_hdf5 && map.dataset.empty())
    findings.report(table + ".dataset", "the key is missing; name the dataset in the HDF5 file");
  if (!is_hdf5 && !map.dataset.empty())
    findings.report(table + ".dataset", "applies to HDF5 files only; leave it out");
  if (map.of == MapOf::material) {
    if (parameters.materials.size() < 2)
      findings.report(table + ".of", "\"material\" requires several materials; give them as [[material]]");
    if (!parameters.specimen.regions.empty())
      findings.report(table + ".of",
                      "\"material\" cannot be combined with [[specimen.region]], which says the same");
  }
  if (!map.checksum.empty() || findings.faulty(table)) return;
  map.checksum = digest_of(parameters, findings).value_or("");
}

}  // namespace crackle::input
