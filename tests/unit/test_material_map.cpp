// SPDX-License-Identifier: GPL-3.0-or-later
// [material.map]: rasters in three formats, their place in the body, and the mistakes that users make.
#include "crackle/ensemble/material_map.h"
#include "crackle/geometry/centroid.h"
#include "crackle/io/raster.h"
#include "io/hdf5.h"
#include "support/box_mesh.h"
#include "support/temporary_folder.h"
#include "unit/input_samples.h"

#include <gmock/gmock.h>
#include <png.h>

#include <array>
#include <cstdint>
#include <fstream>
#include <string>
#include <vector>

namespace crackle::test {
namespace CRACKLE_TEST_FILE {

using ::testing::AllOf;
using ::testing::Contains;
using ::testing::HasSubstr;
using ::testing::IsEmpty;
using ::testing::ThrowsMessage;

constexpr std::size_t n_rows = 14, n_columns = 5;  // along z and y of a plate of 140 x 24.5 mm

/// The value of a cell.
std::uint8_t value_at(std::size_t row, std::size_t column) {
  return static_cast<std::uint8_t>(1 + 5 * row + column);
}

std::vector<std::uint8_t> values() {
  std::vector<std::uint8_t> all;
  for (std::size_t row = 0; row < n_rows; ++row)
    for (std::size_t column = 0; column < n_columns; ++column) all.push_back(value_at(row, column));
  return all;
}

void write_numpy(const std::filesystem::path& file, const std::vector<std::uint8_t>& numbers,
                 const std::string& shape) {
  std::ofstream out(file, std::ios::binary);
  std::string header = "{'descr': '|u1', 'fortran_order': False, 'shape': (" + shape + "), }";
  header.resize(117, ' ');
  header += '\n';
  out << std::string("\x93NUMPY\x01\x00", 8) << static_cast<char>(header.size()) << '\0' << header;
  out.write(reinterpret_cast<const char*>(numbers.data()), static_cast<std::streamsize>(numbers.size()));
}

void write_hdf5(const std::filesystem::path& file, const std::vector<std::uint8_t>& numbers) {
  const io::hdf5::Handle handle(H5Fcreate(file.c_str(), H5F_ACC_TRUNC, H5P_DEFAULT, H5P_DEFAULT), H5Fclose,
                                "create");
  const std::vector<double> doubles(numbers.begin(), numbers.end());
  io::hdf5::write_dataset<double>(handle, "factors", {n_rows, n_columns}, doubles, "");
}

void write_png(const std::filesystem::path& file, const std::vector<std::uint8_t>& numbers,
               unsigned format = PNG_FORMAT_GRAY) {
  png_image image{};
  image.version = PNG_IMAGE_VERSION;
  image.width = n_columns;
  image.height = n_rows;
  image.format = format;
  ASSERT_NE(png_image_write_to_file(&image, file.c_str(), 0, numbers.data(), 0, nullptr), 0);
}

/// Keys of a map over the whole plate.
std::vector<std::pair<std::string, std::string>> map_keys(const std::string& file, const std::string& of) {
  return {{"file", "\"" + file + "\""},
          {"of", "\"" + of + "\""},
          {"axes", R"(["z", "y"])"},
          {"origin", R"(["135 mm", "2.45 mm"])"},
          {"spacing", R"(["-10 mm", "4.9 mm"])"}};  // the first row is at the upper end
}

std::string input_with(const std::vector<std::pair<std::string, std::string>>& keys) {
  auto tables = minimal_tables();
  tables.push_back({"[material.map]", keys});
  return to_text(tables);
}

class MaterialMap : public ::testing::Test {
protected:
  input::Parameters read(const std::vector<std::pair<std::string, std::string>>& keys) const {
    return input::parse(input_with(keys), folder_.path() / "plate.toml");
  }
  std::vector<std::string> errors(const std::vector<std::pair<std::string, std::string>>& keys) const {
    try {
      read(keys);
    } catch (const input::InputError& error) {
      return error.messages();
    }
    return {};
  }

  TemporaryFolder folder_;
  geometry::Realization mesh_ =
      make_box({.size = {0.005, 0.0245, 0.14}, .cells = {2, 10, 50}, .disturbance = 0.2});
};

TEST_F(MaterialMap, GivesEachTetrahedronTheValueAtItsCentroidInAllFormats) {
  write_numpy(folder_.path() / "map.npy", values(), "14, 5");
  write_hdf5(folder_.path() / "map.h5", values());
  write_png(folder_.path() / "map.png", values());
  for (const std::string format : {"npy", "h5", "png"}) {
    auto keys = map_keys("map." + format, "stiffness");
    keys.emplace_back("scale", "0.5");
    if (format == "h5") keys.emplace_back("dataset", "\"factors\"");
    const auto parameters = read(keys);
    auto realization = mesh_;
    ensemble::apply_material_map(parameters, *geometry::make_body(parameters), 3, realization);
    ASSERT_EQ(realization.map_factor.size(), mesh_.tetrahedra.size());
    EXPECT_THAT(realization.material, IsEmpty());
    for (std::size_t t = 0; t < mesh_.tetrahedra.size(); ++t) {
      const auto place = geometry::centroid(mesh_.nodes, mesh_.tetrahedra[t]);
      const auto row = static_cast<std::size_t>((0.14 - place[2]) / 0.01);
      const auto column = static_cast<std::size_t>(place[1] / 0.0049);
      ASSERT_EQ(realization.map_factor[t], 0.5F * static_cast<float>(value_at(row, column))) << format;
    }
  }
}

TEST_F(MaterialMap, OfMaterialsIsOneFileForEachSampleIfItSaysSo) {
  auto tables = minimal_tables();
  std::erase_if(tables, [](const InputTable& table) { return table.header == "[material]"; });
  for (const std::string name : {"\"a\"", "\"b\""})
    tables.push_back({"[[material]]",
                      {{"name", name},
                       {"youngs_modulus", R"("3 GPa")"},
                       {"poisson_ratio", "0.3"},
                       {"density", R"("1000 kg/m^3")"}}});
  auto keys = map_keys("ct-{sample}.npy", "material");
  tables.push_back({"[material.map]", keys});
  set_key(tables, "[ensemble]", "samples", "2");
  std::vector<std::uint8_t> first(values().size(), 0), second = first;
  first[7] = 1;
  second[8] = 1;
  write_numpy(folder_.path() / "ct-0.npy", first, "14, 5");
  const auto parse = [&] { return input::parse(to_text(tables), folder_.path() / "plate.toml"); };
  EXPECT_THAT(parse, ThrowsMessage<input::InputError>(AllOf(HasSubstr("material[1].map.file"),
                                                            HasSubstr("ct-1.npy"), HasSubstr("from 0 on"))));
  write_numpy(folder_.path() / "ct-1.npy", second, "14, 5");
  const auto parameters = parse();
  const auto body = geometry::make_body(parameters);
  std::array<geometry::Realization, 2> meshes{mesh_, mesh_};
  for (std::uint64_t sample = 0; sample < 2; ++sample)
    ensemble::apply_material_map(parameters, *body, sample, meshes[sample]);
  const auto n_of_second = [](const geometry::Realization& mesh) {
    return std::ranges::count(mesh.material, 1);
  };
  // One cell of 70, without its share of randomly moved centroids.
  EXPECT_NEAR(static_cast<double>(n_of_second(meshes[0])) / static_cast<double>(mesh_.tetrahedra.size()),
              1 / 70.0, 0.005);
  EXPECT_NE(meshes[0].material, meshes[1].material);

  // The stored input knows the contents, and needs the files no more.
  const auto stored = input::parse(parameters.text, "/nowhere/input.toml");
  EXPECT_EQ(stored.map->checksum, parameters.map->checksum);
  EXPECT_EQ(input::sample_identity(stored), input::sample_identity(parameters));
  EXPECT_EQ(stored.map->checksum, "in the sample files");
  first[20] = 2;
  write_numpy(folder_.path() / "ct-0.npy", first, "14, 5");
  EXPECT_THAT([&] { ensemble::apply_material_map(parse(), *body, 0, meshes[0]); },
              ThrowsMessage<std::runtime_error>(AllOf(HasSubstr("ct-0.npy"), HasSubstr("the value 2 at"),
                                                      HasSubstr("not the number of a [[material]]"))));
}

TEST_F(MaterialMap, OtherContentsMakeOtherSamples) {
  const auto identity = [&] { return input::sample_identity(read(map_keys("map.npy", "strength"))); };
  write_numpy(folder_.path() / "map.npy", values(), "14, 5");
  const auto before = identity();
  EXPECT_EQ(identity(), before);
  auto other = values();
  ++other[3];
  write_numpy(folder_.path() / "map.npy", other, "14, 5");
  EXPECT_NE(identity(), before);
}

TEST_F(MaterialMap, ErrorsNameTheKey) {
  write_numpy(folder_.path() / "map.npy", values(), "14, 5");
  const auto with = [&](const std::string& key, const std::string& value) {
    auto keys = map_keys("map.npy", "strength");
    const auto known = std::ranges::find(keys, key, &std::pair<std::string, std::string>::first);
    if (known != keys.end())
      known->second = value;
    else
      keys.emplace_back(key, value);
    return errors(keys);
  };
  EXPECT_THAT(with("scale", "1"), IsEmpty());
  EXPECT_THAT(with("file", "\"no.npy\""), Contains(HasSubstr("is not a readable file")));
  EXPECT_THAT(with("file", "\"map.tif\""), Contains(HasSubstr("ends in .h5, .npy or .png")));
  EXPECT_THAT(with("file", "\"map.h5\""), Contains(HasSubstr("dataset: the key is missing")));
  EXPECT_THAT(with("dataset", "\"a\""), Contains(HasSubstr("HDF5 files only")));
  EXPECT_THAT(with("axes", R"(["z", "z"])"), Contains(HasSubstr("names an axis twice")));
  EXPECT_THAT(with("axes", R"(["z"])"), Contains(HasSubstr("has 2 lengths for 1 axes")));
  EXPECT_THAT(with("spacing", R"(["0 mm", "1 mm"])"), Contains(HasSubstr("spacing: is 0")));
  EXPECT_THAT(with("of", "\"material\""), Contains(HasSubstr("requires several materials")));
  EXPECT_THAT(with("of", "\"density\""), Contains(HasSubstr("\"stiffness\"")));
}

TEST_F(MaterialMap, FilesThatDoNotFitAreNamed) {
  const auto problem_with = [&](const std::vector<std::pair<std::string, std::string>>& keys) {
    try {
      const auto parameters = read(keys);
      auto realization = mesh_;
      ensemble::apply_material_map(parameters, *geometry::make_body(parameters), 0, realization);
    } catch (const std::runtime_error& error) {
      return std::string(error.what());
    }
    return std::string("none");
  };
  const auto path = folder_.path() / "map.npy";
  const auto keys = map_keys("map.npy", "strength");
  write_numpy(path, values(), "14, 5");
  EXPECT_EQ(problem_with(keys), "none");
  auto shifted = keys;
  shifted[3].second = R"(["125 mm", "2.45 mm"])";
  EXPECT_THAT(problem_with(shifted),
              AllOf(HasSubstr("map.npy: covers z = -10 mm to 130 mm"), HasSubstr("to 140 mm")));
  write_numpy(path, values(), "70,");
  EXPECT_THAT(problem_with(keys), HasSubstr("has the shape 70, but [material.map] names 2 axes"));
  write_numpy(path, {1, 2, 3}, "14, 5");
  EXPECT_THAT(problem_with(keys), HasSubstr("is truncated"));
  auto zero = values();
  zero[30] = 0;
  write_numpy(path, zero, "14, 5");
  EXPECT_THAT(problem_with(keys), HasSubstr("not a factor; give values above 0"));
  std::ofstream(path) << "no array";
  EXPECT_THAT(problem_with(keys), HasSubstr("is not a NumPy array"));
  auto picture = keys;
  picture[0].second = "\"map.png\"";
  std::ofstream(folder_.path() / "map.png") << "no picture";
  testing::internal::CaptureStderr();
  EXPECT_THAT(problem_with(picture), HasSubstr("is not a readable PNG picture"));
  EXPECT_EQ(testing::internal::GetCapturedStderr(), "") << "the message is the program's";
  write_png(folder_.path() / "map.png", std::vector<std::uint8_t>(3 * n_rows * n_columns, 9), PNG_FORMAT_RGB);
  EXPECT_THAT(problem_with(picture), HasSubstr("has colours"));
  write_numpy(path, values(), "14, 5");
  auto other = keys;
  other.emplace_back("checksum", "\"5 bytes\"");
  EXPECT_THAT(problem_with(other), HasSubstr("has other contents than the checksum in [material.map] says"));
}

}  // namespace CRACKLE_TEST_FILE
}  // namespace crackle::test
