// SPDX-License-Identifier: GPL-3.0-or-later
#include "analysis/result_list.h"
#include "common/packing.h"
#include "io/ensemble_file.h"
#include "io/hdf5.h"

#include "io/sample_file.h"
#include "parallel/agreement.h"
#include "support/group.h"
#include "support/result_comparison.h"
#include "support/temporary_folder.h"

#include <gmock/gmock.h>

#include <cmath>
#include <fstream>
#include <limits>
#include <optional>

namespace crackle::io {
namespace CRACKLE_TEST_FILE {

namespace fs = std::filesystem;
using analysis::SampleStatus;
using analysis::SampleSummary;

constexpr double none = std::numeric_limits<double>::quiet_NaN();

class EnsembleFile : public testing::Test {
protected:
  EnsembleFile() {
    parameters.text = "[ensemble]\nsamples = 7\n# 20 µm\n" + std::string(100'000, '#') + "\n";
    parameters.ensemble.samples = 7;
    parameters.seed = 2012;
    parameters.specimen = {
        {0.003, 0.016, 0.024},
        {{plane::Face::y_min, 0.009, 0.004, 0.0006}, {plane::Face::y_max, 0.015, 0.004, 0.0006}}};
    parameters.sections = {.y = {0.007, 0.009}, .z = {0.01225}};
    for (int i = 0; i < 7; ++i) {
      SampleSummary row = analysis::empty_summary(2, 3, SampleStatus::done);
      row.onset_force = 380 + i;
      row.onset_time = 76 + 0.1 * i;
      row.outcome = i % 4;
      row.pattern = 1 + i % 3;
      row.leading_start = i % 3 - 1;
      row.overlap = 0.1 * i;
      row.branching_points = i;
      row.kinks = 3 * i;
      row.breaks = 1'000 * i;
      row.crack_area = 1e-4 * i;
      row.crack_speed_max = 600 - i;
      row.energy_error = 1e-5 * i;
      row.position = {0.065 + 1e-4 * i, none, 0.0655, 0.075, 0.0751 - 1e-4 * i, none};
      row.z_spread = {1e-4 * i, none, 2e-4, 3e-4, 4e-4, none};
      row.branches = {1, 0, 2, 1, 1, 0};
      row.wall_time = i;
      rows.push_back(row);
    }
    if (world.is_root()) {
      base.position = {{0, 0, 0}, {0.005, 1.0 / 3, 0.14}, {1e-3, 2e-3, 3e-3}};
      base.spacing = {3e-4, 1e-3, 0.1 / 3};
      base.movable = {0, 5, 7};
    }
    rows[2] = analysis::empty_summary(2, 3, SampleStatus::failed, "sample 2: µ out of range");
    rows[5] = analysis::empty_summary(2, 3, SampleStatus::failed, "reason\nin two lines");
    rows[6] = analysis::empty_summary(2, 3, SampleStatus::pending);
    // All ranks use the root's folder.
    std::string name(4096, '\0');
    if (world.is_root()) name.replace(0, folder.path().string().size(), folder.path().string());
    MPI_Bcast(name.data(), static_cast<int>(name.size()), MPI_CHAR, 0, world.get());
    shared_folder = name.c_str();
  }
  ~EnsembleFile() override { MPI_Barrier(world.get()); }

  analysis::Statistics statistics() const { return analysis::make_statistics(rows, 2, 3, 0.9); }
  EnsembleBlock block(std::size_t first, std::size_t count) const {
    const auto begin = rows.begin() + static_cast<std::ptrdiff_t>(first);
    return {first, {begin, begin + static_cast<std::ptrdiff_t>(count)}};
  }
  /// Evenly distributed rows, with one more on the first ranks.
  EnsembleBlock even_block(const parallel::Communicator& group) const {
    const auto n = rows.size();
    const auto size = static_cast<std::size_t>(group.size());
    const auto rank = static_cast<std::size_t>(group.rank());
    return block(n * rank / size, n * (rank + 1) / size - n * rank / size);
  }
  std::string agreed_failure(const fs::path& file, const EnsembleBlock& mine) const {
    try {
      write_ensemble(world, file, parameters, mine, statistics(), base);
    } catch (const parallel::AgreedError& error) {
      return error.what();
    }
    return "no error";
  }
  std::ptrdiff_t n_entries() const {
    return std::distance(fs::directory_iterator(shared_folder), fs::directory_iterator());
  }

  parallel::Communicator world{test::group()};
  test::TemporaryFolder folder;
  fs::path shared_folder;
  input::Parameters parameters;
  std::vector<SampleSummary> rows;
  geometry::MotherPoints base;  ///< on the root
};

TEST_F(EnsembleFile, HoldsThePositionsAtTheSectionsYOnce) {
  const fs::path file = shared_folder / "ensemble.h5";
  write_ensemble(world, file, parameters, even_block(world), statistics(), base);
  const hdf5::Handle root = hdf5::open_for_reading(file);
  const auto z = hdf5::read_dataset<double>(root, "crack_path/z", {7, 2, 2});
  for (std::size_t i = 0; i < rows.size(); ++i) {
    const std::vector<double>& p = rows[i].position;
    EXPECT_THAT((std::vector<double>{z.begin() + static_cast<std::ptrdiff_t>(4 * i),
                                     z.begin() + static_cast<std::ptrdiff_t>(4 * i + 4)}),
                testing::Pointwise(testing::NanSensitiveDoubleEq(), {p[0], p[1], p[3], p[4]}));
  }
  EXPECT_EQ(hdf5::read_dataset<std::int32_t>(root, "crack_path/section_axis", {3}),
            (std::vector<std::int32_t>{1, 1, 2}));
  const hdf5::Handle axis(H5Dopen2(root, "crack_path/section_axis", H5P_DEFAULT), H5Dclose, "axis");
  EXPECT_EQ(hdf5::read_text_attribute(axis, "categories"), "1 y, 2 z");
}

TEST_F(EnsembleFile, HoldsTheEndsOfLinesWhereThereAreSome) {
  const fs::path file = shared_folder / "ensemble.h5";
  write_ensemble(world, file, parameters, even_block(world), statistics(), base);
  EXPECT_LE(H5Lexists(hdf5::open_for_reading(file), "crack_path/section_line", H5P_DEFAULT), 0);
  parameters.sections = {
      .y = {0.007}, .z = {}, .lines = {{{0.001, 0.002}, {0.003, 0.004}}, {{5, 6}, {7, 8}}}};
  write_ensemble(world, file, parameters, even_block(world), statistics(), base);
  const hdf5::Handle root = hdf5::open_for_reading(file);
  EXPECT_EQ(hdf5::read_dataset<std::int32_t>(root, "crack_path/section_axis", {3}),
            (std::vector<std::int32_t>{1, 0, 0}));
  EXPECT_EQ(hdf5::read_dataset<double>(root, "crack_path/section_line", {2, 2, 2}),
            (std::vector<double>{0.001, 0.002, 0.003, 0.004, 5, 6, 7, 8}));
  const EnsembleContent content = read_ensemble(file);
  EXPECT_EQ(content.sections.all(), parameters.sections.all());
  EXPECT_EQ(to_bytes(content.samples[0]), to_bytes(rows[0]));
}

TEST_F(EnsembleFile, WithoutSectionsYIsWhole) {
  parameters.sections = {.y = {}, .z = {0.007, 0.009, 0.01225}};
  const fs::path file = shared_folder / "ensemble.h5";
  write_ensemble(world, file, parameters, even_block(world), statistics(), base);
  const EnsembleContent content = read_ensemble(file);
  EXPECT_TRUE(content.sections.y.empty());
  EXPECT_EQ(content.sections.z, parameters.sections.z);
  EXPECT_EQ(to_bytes(content.samples[0]), to_bytes(rows[0]));
}

TEST_F(EnsembleFile, ReadsBackEverythingThatWasWritten) {
  const fs::path file = shared_folder / "ensemble.h5";
  write_ensemble(world, file, parameters, even_block(world), statistics(), base);
  const EnsembleContent content = read_ensemble(file);
  EXPECT_EQ(content.input_text, parameters.text);
  EXPECT_EQ(content.sections.y, parameters.sections.y);
  EXPECT_EQ(content.sections.z, parameters.sections.z);
  ASSERT_EQ(content.samples.size(), rows.size());
  for (std::size_t i = 0; i < rows.size(); ++i) {
    EXPECT_EQ(to_bytes(content.samples[i]), to_bytes(rows[i])) << "sample " << i;
  }
  const geometry::MotherPoints points = read_mother_points(file, parameters);
  for (const geometry::MotherPoints& stored : {content.base, points}) {
    EXPECT_THAT(stored.position, testing::SizeIs(3));
    EXPECT_THAT(stored.movable, testing::ElementsAre(0, 5, 7));
    if (!world.is_root()) continue;
    EXPECT_EQ(stored.position, base.position);
    EXPECT_EQ(stored.spacing, base.spacing);
  }
  EXPECT_EQ(n_entries(), 1) << "a partial file is left";
  std::printf("rank %d of %d: %zu rows\n", world.rank(), world.size(), content.samples.size());
}

TEST_F(EnsembleFile, IsTheSameForAnyNumberOfRanks) {
  // Written by one rank alone and by all, with rows evenly distributed or all on the last rank.
  const fs::path alone = shared_folder / "alone.h5";
  const fs::path together = shared_folder / "together.h5";
  const fs::path last = shared_folder / "last.h5";
  const parallel::Communicator self = world.split(world.rank(), 0);
  if (world.is_root()) write_ensemble(self, alone, parameters, block(0, 7), statistics(), base);
  write_ensemble(world, together, parameters, even_block(world), statistics(), base);
  const bool is_last = world.rank() + 1 == world.size();
  write_ensemble(world, last, parameters, block(0, is_last ? 7 : 0), statistics(), base);
  EXPECT_THAT(differences(alone, together), testing::IsEmpty());
  EXPECT_THAT(differences(alone, last), testing::IsEmpty());
  // The comparison detects a changed row.
  rows[3].onset_time = std::nextafter(rows[3].onset_time, 0);
  write_ensemble(world, last, parameters, even_block(world), statistics(), base);
  EXPECT_THAT(differences(alone, last), testing::ElementsAre("/samples/onset_time"));
  // And a moved mother point.
  if (world.is_root()) base.position[1][1] = std::nextafter(base.position[1][1], 0);
  write_ensemble(world, last, parameters, even_block(world), statistics(), base);
  EXPECT_THAT(differences(together, last),
              testing::ElementsAre("/mother_points/position", "/samples/onset_time"));
}

TEST_F(EnsembleFile, MotherPointsOfAnotherInputAreRefused) {
  const fs::path file = shared_folder / "ensemble.h5";
  parameters.mesh.points_digest = "some points";
  write_ensemble(world, file, parameters, even_block(world), statistics(), base);
  EXPECT_EQ(read_mother_points(file, parameters).size(), 3u);
  parameters.mesh.points_digest = "other points";
  EXPECT_THAT([&] { read_mother_points(file, parameters); },
              testing::ThrowsMessage<std::runtime_error>(
                  testing::HasSubstr("was made from other points (some points, not other points)")));
  parameters.mesh.points_digest = "some points";
  parameters.mesh.growth += 0.01;
  EXPECT_THAT([&] { read_mother_points(file, parameters); },
              testing::ThrowsMessage<std::runtime_error>(testing::HasSubstr("was made from another input")));
}

TEST_F(EnsembleFile, RowsThatNobodyHoldsArePending) {
  const fs::path file = shared_folder / "ensemble.h5";
  write_ensemble(world, file, parameters, block(1, world.is_root() ? 3 : 0), statistics(), base);
  const auto samples = read_ensemble(file).samples;
  for (std::size_t i = 0; i < samples.size(); ++i) {
    const SampleSummary expected =
        i >= 1 && i < 4 ? rows[i] : analysis::empty_summary(2, 3, SampleStatus::pending);
    EXPECT_EQ(to_bytes(samples[i]), to_bytes(expected)) << "sample " << i;
  }
}

TEST_F(EnsembleFile, EnsembleWithoutNotchesOrSections) {
  parameters.specimen.notches.clear();
  for (SampleSummary& row : rows) {
    row.position.clear();
    row.z_spread.clear();
    row.arrival_time.clear();
    row.branches.clear();
    row.leading_start = -1;
  }
  const fs::path file = shared_folder / "ensemble.h5";
  write_ensemble(world, file, parameters, even_block(world), analysis::make_statistics(rows, 0, 3), base);
  const EnsembleContent content = read_ensemble(file);
  EXPECT_EQ(content.samples.size(), 7u);
  EXPECT_EQ(content.samples[1].onset_force, rows[1].onset_force);
}

TEST_F(EnsembleFile, WritesOftenWithoutHanging) {
  const fs::path file = shared_folder / "ensemble.h5";
  for (int i = 0; i < 20; ++i) write_ensemble(world, file, parameters, even_block(world), statistics(), base);
  EXPECT_EQ(read_ensemble(file).samples.size(), 7u);
}

TEST_F(EnsembleFile, FailuresAreTheSameOnAllRanks) {
  const bool is_last = world.rank() + 1 == world.size();
  const fs::path file = shared_folder / "ensemble.h5";

  // Rows beyond the end, on one rank only.
  std::string message = agreed_failure(file, is_last ? EnsembleBlock{5, block(0, 4).rows} : block(0, 0));
  EXPECT_THAT(message, testing::HasSubstr("rows 5 to 9: the ensemble has 7 samples"));

  // A row of the wrong shape, on one rank only.
  EnsembleBlock wrong = block(0, is_last ? 1 : 0);
  if (is_last) wrong.rows[0].position.pop_back();
  message = agreed_failure(file, wrong);
  EXPECT_THAT(message, testing::HasSubstr("row 0: 5 values position"));

  // The same row on two ranks.
  if (world.size() > 1) {
    message = agreed_failure(file, block(0, world.rank() < 2 ? 2 : 0));
    EXPECT_THAT(message, testing::HasSubstr("row 0 is held by two ranks"));
  }

  // An unwritable location; only the root tries.
  if (world.is_root()) std::ofstream(shared_folder / "plain") << "a file, not a folder";
  MPI_Barrier(world.get());
  message = agreed_failure(shared_folder / "plain/ensemble.h5", even_block(world));
  EXPECT_THAT(message,
              testing::StartsWith("cannot write '" + (shared_folder / "plain/ensemble.h5").string()));
  EXPECT_THAT(message, testing::HasSubstr("Not a directory"));
  if (world.is_root()) std::printf("%s\n", message.c_str());

  EXPECT_EQ(n_entries(), 1) << "only the plain file";
  // Statistics of another ensemble.
  rows.pop_back();
  message = agreed_failure(file, block(0, 0));
  EXPECT_THAT(message, testing::HasSubstr("running_mean"));
  EXPECT_EQ(n_entries(), 1);
}

TEST_F(EnsembleFile, ForeignAndTruncatedFilesAreRefused) {
  if (!world.is_root()) return;
  const parallel::Communicator self(MPI_COMM_SELF);
  const fs::path file = folder.path() / "ensemble.h5";
  const auto refusal = [&] {
    try {
      read_ensemble(file);
    } catch (const std::runtime_error& error) {
      std::printf("%s\n", error.what());
      return std::string(error.what());
    }
    return std::string("not refused");
  };
  EXPECT_THAT(refusal(), testing::HasSubstr("No such file"));
  write_ensemble(self, file, parameters, block(0, 7), statistics(), base);
  EXPECT_EQ(refusal(), "not refused");
  write_failed_sample(folder.path() / "sample.h5", parameters, 2, rows[2]);
  EXPECT_THROW(read_ensemble(folder.path() / "sample.h5"), std::runtime_error);
  fs::resize_file(file, fs::file_size(file) / 2);
  EXPECT_THAT(refusal(), testing::HasSubstr("truncated"));
}

TEST_F(EnsembleFile, SamplesWithNumbersThatNoComputationGivesArePending) {
  const fs::path file = shared_folder / "ensemble.h5";
  constexpr double infinite = std::numeric_limits<double>::infinity();
  parameters.materials.resize(2);
  const analysis::Statistics found = statistics();
  for (SampleSummary& row : rows) {
    row.fragments.heavier.assign(analysis::fragment_shares().size(), 2);
    row.crack_area_in = {1, 2};
  }
  rows[0].peak_load = rows[1].fragments.number = rows[3].crack_area_in[1] = infinite;
  rows[4].fragments.heavier[2] = infinite;
  write_ensemble(world, file, parameters, even_block(world), found, base);
  const auto samples = read_ensemble(file).samples;
  for (const auto& [sample, name] :
       {std::pair{0, "peak_load"}, {1, "number"}, {3, "crack_area_in"}, {4, "heavier"}}) {
    const SampleSummary& row = samples.at(static_cast<std::size_t>(sample));
    EXPECT_EQ(row.status, SampleStatus::pending);
    EXPECT_THAT(row.error, testing::HasSubstr(name + std::string(" is infinite")));
  }
  EXPECT_NO_THROW(analysis::make_statistics(samples, 2, 3));
}

TEST_F(EnsembleFile, RowsOfAllRanksAreGatheredInOrder) {
  const EnsembleBlock mine = even_block(world);
  const auto gathered = analysis::gather_on_root(world, mine.rows);
  ASSERT_EQ(gathered.size(), world.is_root() ? rows.size() : 0);
  for (std::size_t i = 0; i < gathered.size(); ++i) {
    EXPECT_EQ(to_bytes(gathered[i]), to_bytes(rows[i])) << "sample " << i;
  }
}

}  // namespace CRACKLE_TEST_FILE
}  // namespace crackle::io
