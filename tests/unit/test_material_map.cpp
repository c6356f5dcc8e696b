// SPDX-License-Identifier: GPL-3.0-or-later
// [material.map]: rasters in two formats, their place in the body, and the mistakes that users make.
#include "ensemble/material_map.h"
#include "ensemble/memory.h"
#include "geometry/point.h"
#include "io/hdf5.h"
#include "io/raster.h"
#include "support/box_mesh.h"
#include "support/temporary_folder.h"
#include "unit/input_samples.h"

#include <gmock/gmock.h>
#include <png.h>

#include <array>
#include <cstdint>
#include <filesystem>
#include <fstream>
#include <string>
#include <typeinfo>
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

template <class Number>
void write_hdf5(const std::filesystem::path& file, const std::vector<Number>& numbers,
                const io::hdf5::Shape& shape = {n_rows, n_columns}) {
  const io::hdf5::Handle handle(H5Fcreate(file.c_str(), H5F_ACC_TRUNC, H5P_DEFAULT, H5P_DEFAULT), H5Fclose,
                                "create");
  io::hdf5::write_dataset<Number>(handle, "factors", shape, numbers, "");
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
  std::vector<std::pair<std::string, std::string>> keys{
      {"file", "\"" + file + "\""},
      {"of", "\"" + of + "\""},
      {"axes", R"(["z", "y"])"},
      {"origin", R"(["135 mm", "2.45 mm"])"},
      {"spacing", R"(["-10 mm", "4.9 mm"])"}};  // the first row is at the upper end
  if (file.ends_with(".h5")) keys.emplace_back("dataset", "\"factors\"");
  return keys;
}

std::string input_with(const std::vector<std::pair<std::string, std::string>>& keys) {
  auto tables = minimal_tables();
  tables.push_back({"[material.map]", keys});
  return to_text(tables);
}

/// A dataset "factors" that is made by `make(file, space)`.
template <class Make>
void write_dataset(const std::filesystem::path& file, const Make& make) {
  using io::hdf5::Handle;
  const Handle handle(H5Fcreate(file.c_str(), H5F_ACC_TRUNC, H5P_DEFAULT, H5P_DEFAULT), H5Fclose, "create");
  const std::array<hsize_t, 2> shape{n_rows, n_columns};
  const Handle space(H5Screate_simple(2, shape.data(), nullptr), H5Sclose, "space");
  make(handle, space);
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
  const auto bytes = values();
  write_hdf5<double>(folder_.path() / "map.h5", {bytes.begin(), bytes.end()});
  write_png(folder_.path() / "map.png", values());
  for (const std::string format : {"h5", "png"}) {
    auto keys = map_keys("map." + format, "stiffness");
    keys.emplace_back("scale", "0.5");
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
  auto keys = map_keys("ct-{sample}.h5", "material");
  tables.push_back({"[material.map]", keys});
  set_key(tables, "[ensemble]", "samples", "2");
  std::vector<std::uint8_t> first(values().size(), 0), second = first;
  first[7] = 1;
  second[8] = 1;
  write_hdf5(folder_.path() / "ct-0.h5", first);
  const auto parse = [&] { return input::parse(to_text(tables), folder_.path() / "plate.toml"); };
  EXPECT_THAT(parse, ThrowsMessage<input::InputError>(AllOf(HasSubstr("material[1].map.file"),
                                                            HasSubstr("ct-1.h5"), HasSubstr("from 0 on"))));
  write_hdf5(folder_.path() / "ct-1.h5", second);
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
  write_hdf5(folder_.path() / "ct-0.h5", first);
  EXPECT_THAT([&] { ensemble::apply_material_map(parse(), *body, 0, meshes[0]); },
              ThrowsMessage<std::runtime_error>(AllOf(HasSubstr("ct-0.h5"), HasSubstr("the value 2 at"),
                                                      HasSubstr("not the number of a [[material]]"))));
}

TEST_F(MaterialMap, OtherContentsMakeOtherSamples) {
  const auto identity = [&] { return input::sample_identity(read(map_keys("map.h5", "strength"))); };
  write_hdf5(folder_.path() / "map.h5", values());
  const auto before = identity();
  EXPECT_EQ(identity(), before);
  auto other = values();
  ++other[3];
  write_hdf5(folder_.path() / "map.h5", other);
  EXPECT_NE(identity(), before);
}

TEST_F(MaterialMap, ErrorsNameTheKey) {
  write_hdf5(folder_.path() / "map.h5", values());
  const auto with = [&](const std::string& key, const std::string& value) {
    auto keys = map_keys("map.h5", "strength");
    const auto known = std::ranges::find(keys, key, &std::pair<std::string, std::string>::first);
    if (known != keys.end())
      known->second = value;
    else
      keys.emplace_back(key, value);
    return errors(keys);
  };
  EXPECT_THAT(with("scale", "1"), IsEmpty());
  EXPECT_THAT(with("file", "\"no.h5\""), Contains(HasSubstr("is not a readable file")));
  EXPECT_THAT(with("file", "\"map.npy\""),
              Contains(AllOf(HasSubstr("ends in .h5 or .png"), HasSubstr("= numpy.load(\"ct.npy\")"))));
  EXPECT_THAT(with("file", "\"map.png\""), Contains(HasSubstr("HDF5 files only")));
  auto without_dataset = map_keys("map.h5", "strength");
  without_dataset.pop_back();
  EXPECT_THAT(errors(without_dataset), Contains(HasSubstr("dataset: the key is missing")));
  EXPECT_THAT(with("axes", R"(["z", "z"])"), Contains(HasSubstr("names an axis twice")));
  EXPECT_THAT(with("axes", R"(["z"])"), Contains(HasSubstr("has 2 lengths for 1 axis")));
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
  const auto path = folder_.path() / "map.h5";
  const auto keys = map_keys("map.h5", "strength");
  write_hdf5(path, values());
  EXPECT_EQ(problem_with(keys), "none");
  auto shifted = keys;
  shifted[3].second = R"(["125 mm", "2.45 mm"])";
  EXPECT_THAT(problem_with(shifted),
              AllOf(HasSubstr("map.h5: covers z = -10 mm to 130 mm"), HasSubstr("to 140 mm")));
  write_hdf5(path, values(), {70});
  EXPECT_THAT(problem_with(keys), HasSubstr("has the shape 70, but [material.map] names 2 axes"));
  auto zero = values();
  zero[30] = 0;
  write_hdf5(path, zero);
  EXPECT_THAT(problem_with(keys), HasSubstr("not a factor; give values above 0"));
  const auto picture = map_keys("map.png", "strength");
  std::ofstream(folder_.path() / "map.png") << "no picture";
  testing::internal::CaptureStderr();
  std::ofstream(path) << "no dataset";
  EXPECT_THAT(problem_with(keys), HasSubstr("map.h5: not a complete HDF5 file"));
  write_dataset(path, [](hid_t, hid_t) {});
  EXPECT_THAT(problem_with(keys), HasSubstr("map.h5: dataset factors"));
  EXPECT_THAT(problem_with(picture), HasSubstr("is not a readable PNG picture"));
  EXPECT_EQ(testing::internal::GetCapturedStderr(), "") << "the message is the program's";
  write_png(folder_.path() / "map.png", std::vector<std::uint8_t>(3 * n_rows * n_columns, 9), PNG_FORMAT_RGB);
  EXPECT_THAT(problem_with(picture), HasSubstr("has colours"));
  write_hdf5(path, values());
  auto other = keys;
  other.emplace_back("checksum", "\"5 bytes\"");
  EXPECT_THAT(problem_with(other), HasSubstr("has other contents than the checksum in [material.map] says"));
}

// The checksum is that of one file, and a number that nobody wrote is no factor.
TEST_F(MaterialMap, HasItsValuesInItsOwnFile) {
  const auto file = folder_.path() / "map.h5";
  const auto keys = map_keys("map.h5", "strength");
  const auto problem = [&] {
    try {
      ensemble::check_material_map(read(keys).map, *geometry::make_body(read(keys)));
    } catch (const std::runtime_error& error) {
      return std::string(error.what());
    }
    return std::string("none");
  };
  const auto create = [](hid_t in, hid_t space, hid_t list) {
    return io::hdf5::Handle(H5Dcreate2(in, "factors", H5T_STD_U8LE, space, H5P_DEFAULT, list, H5P_DEFAULT),
                            H5Dclose, "dataset");
  };
  const auto elsewhere = HasSubstr("map.h5: the values of \"factors\" are in other files");
  const auto incomplete = HasSubstr("map.h5: is not complete: values of \"factors\" were never written");

  write_hdf5(folder_.path() / "target.h5", values());
  write_dataset(file, [](hid_t in, hid_t) {
    H5Lcreate_external("target.h5", "factors", in, "factors", H5P_DEFAULT, H5P_DEFAULT);
  });
  EXPECT_THAT(problem(), elsewhere);
  write_dataset(file, [&](hid_t in, hid_t space) {
    const auto list = io::hdf5::property_list(H5P_DATASET_CREATE);
    H5Pset_virtual(list, space, "absent.h5", "factors", space);
    create(in, space, list);
  });
  EXPECT_THAT(problem(), elsewhere);
  write_dataset(file, [&](hid_t in, hid_t space) { create(in, space, H5P_DEFAULT); });
  EXPECT_THAT(problem(), incomplete);
  const auto in_chunks = [&](bool is_whole, bool has_fill_value) {
    write_dataset(file, [&](hid_t in, hid_t space) {
      const auto list = io::hdf5::property_list(H5P_DATASET_CREATE);
      const std::array<hsize_t, 2> chunk{4, n_columns}, start{0, 0}, part{is_whole ? n_rows : 8, n_columns};
      H5Pset_chunk(list, 2, chunk.data());
      H5Pset_deflate(list, 1);
      const std::uint8_t fill = 7;
      if (has_fill_value) H5Pset_fill_value(list, H5T_NATIVE_UINT8, &fill);
      const auto dataset = create(in, space, list);
      const io::hdf5::Handle written(H5Screate_simple(2, part.data(), nullptr), H5Sclose, "space");
      H5Sselect_hyperslab(space, H5S_SELECT_SET, start.data(), nullptr, part.data(), nullptr);
      H5Dwrite(dataset, H5T_NATIVE_UINT8, written, space, H5P_DEFAULT, values().data());
    });
    return problem();
  };
  EXPECT_THAT(in_chunks(false, false), incomplete);
  EXPECT_EQ(in_chunks(false, true), "none");
  EXPECT_EQ(in_chunks(true, false), "none");
}

TEST_F(MaterialMap, KeepsNumbersInNoMoreMemoryThanTheyNeed) {
  const auto memory = [&] { return io::raster_memory(*read(map_keys("map.h5", "strength")).map); };
  const auto value = [&] {
    const auto parameters = read(map_keys("map.h5", "strength"));
    return io::Raster(*parameters.map, 0, geometry::make_body(parameters)->bounds())
        .at({0.001, 0.0246 * 0.5, 0.0349});
  };
  const auto as = [&](auto number) {
    const auto bytes = values();
    write_hdf5<decltype(number)>(folder_.path() / "map.h5", {bytes.begin(), bytes.end()});
    EXPECT_EQ(value(), value_at(10, 2)) << typeid(number).name();
    return memory() / 70;
  };
  EXPECT_EQ(as(std::uint8_t{}), 1);
  EXPECT_EQ(as(float{}), 4);
  EXPECT_EQ(as(std::int32_t{}), 8);
  EXPECT_EQ(as(double{}), 8);
  // Before the mesh, on top of the rest.
  const auto small = read(map_keys("map.h5", "strength"));
  const auto layout = ensemble::one_group(1);
  const double without = ensemble::memory_demand(small, 100, 500, layout).master;
  write_hdf5(folder_.path() / "map.h5", std::vector<std::uint8_t>(10'000'000, 1), {10000, 1000});
  EXPECT_NEAR(ensemble::memory_demand(small, 100, 500, layout).master - without, 10e6, 0.2e6);
}

TEST_F(MaterialMap, EachCaseOfASweepHasItsOwn) {
  write_hdf5(folder_.path() / "a.h5", values());
  write_hdf5(folder_.path() / "b.h5", std::vector<std::uint8_t>(70, 1));
  const std::string text = input_with(map_keys("a.h5", "strength")) +
                           "[[sweep]]\nkey = \"material.map.file\"\nvalues = [\"a.h5\", \"b.h5\"]\n";
  const auto name = folder_.path() / "plate.toml";
  const auto parameters = input::parse(text, name);
  const auto cases = input::sweep_cases(parameters, name);
  ASSERT_EQ(cases.size(), 2U);
  for (const auto& one : cases) {
    const std::string checksum = one.parameters.map->checksum;
    EXPECT_THAT(one.parameters.text, HasSubstr("checksum = \"" + checksum + "\""));
    EXPECT_EQ(input::parse(one.parameters.text, "/nowhere/input.toml").map->checksum, checksum);
  }
  EXPECT_NE(cases[0].parameters.map->checksum, cases[1].parameters.map->checksum);
  // Results are read without the rasters.
  const std::filesystem::path elsewhere = "/nowhere/sweep.toml";
  const auto stored = input::parse(parameters.text, elsewhere);
  EXPECT_EQ(input::sweep_cases(stored, elsewhere, true).size(), 2U);
  EXPECT_THROW(input::sweep_cases(stored, elsewhere), input::InputError);
}

}  // namespace CRACKLE_TEST_FILE
}  // namespace crackle::test
