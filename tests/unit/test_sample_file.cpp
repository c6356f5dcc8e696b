// SPDX-License-Identifier: GPL-3.0-or-later
#include "analysis/result_list.h"
#include "common/packing.h"
#include "common/real.h"
#include "cracks/front_trajectory.h"
#include "input/reader.h"
#include "io/ensemble_file.h"
#include "io/sample_file.h"
#include "support/result_comparison.h"
#include "support/structured_mesh.h"
#include "support/temporary_folder.h"

#include "io/hdf5.h"
#include "io/partial_file.h"

#include <gmock/gmock.h>
#include <sys/resource.h>

#include <chrono>
#include <cmath>
#include <csignal>
#include <fstream>
#include <iterator>
#include <map>
#include <span>
#include <thread>
#include <tuple>

namespace crackle::io {
namespace CRACKLE_TEST_FILE {

namespace fs = std::filesystem;
using analysis::SampleStatus;
using analysis::SampleSummary;

std::string bytes_of(const fs::path& file) {
  std::ifstream stream(file, std::ios::binary);
  return {std::istreambuf_iterator<char>(stream), {}};
}

void put_bytes(const fs::path& file, const std::string& bytes) {
  std::ofstream(file, std::ios::binary) << bytes;
}

std::ptrdiff_t n_entries(const fs::path& folder) {
  return std::distance(fs::directory_iterator(folder), fs::directory_iterator());
}

class SampleFile : public ::testing::Test {
protected:
  SampleFile() {
    parameters.text = "[ensemble]\nsamples = 5  # stress of 35 MPa, 20 µm\n";
    parameters.ensemble.samples = 5;
    parameters.seed = 2012;
    parameters.mesh.growth = 0.1;
    parameters.specimen = test::notched_plate();
    parameters.sections.y = {6.5, 8.5, 13.5};
    result.outcome = dynamics::Outcome::running;
    result.onset_force = 380.9;
    result.onset_time = 76.18;
    result.time_step = 5e-9;
    result.stable_step = 8e-9;
    result.energy_error = 2e-4;
    result.breaks = mesh.break_between([](const geometry::Point& p) { return p[2] > 8.5 ? 1 : 0; },
                                       [](const geometry::Point& p) { return p[1] > 4 ? p[1] : -1.0; });
    result.energy = {{0, 0, 1, 1, 0, 0, 3}, {1e-6, 0.25, 0.5, 1, 0.25, 0, 9}};
    const std::size_t n = mesh.realization().nodes.size() * 3;
    for (int f = 0; f < 3; ++f) {
      result.frames.push_back({f * 1e-6, std::vector<float>(n, float(f)), std::vector<float>(n, 2.5f), f});
    }
    result.timings = {1, 2, 3, 4, 5e6};
    surface = cracks::make_crack_surface(mesh.body(), mesh.realization(), result.breaks, result.onset_time);
    branches = cracks::find_branches(mesh.body(), surface);
    lines = cracks::crack_lines(mesh.body(), surface, branches);
    crossings =
        cracks::section_crossings(mesh.body(), surface, branches, cracks::planes_of(parameters.sections));
    summary = analysis::summarize(mesh.body(), result, surface, lines, branches, crossings,
                                  cracks::front_trajectories(mesh.body(), surface, rayleigh_speed()));
  }
  double rayleigh_speed() const { return mechanics::rayleigh_speed(parameters.material()); }
  void write(const fs::path& file, std::uint64_t sample = 3) const {
    write_sample(file, {parameters, sample, mesh.realization(), result, surface, lines, branches, crossings,
                        summary, crack_history});
  }
  std::string refusal(const fs::path& file, std::uint64_t sample = 3) const {
    try {
      read_summary(file, parameters, sample);
    } catch (const std::runtime_error& error) {
      std::printf("%s\n", error.what());
      return error.what();
    }
    return "not refused";
  }

  test::TemporaryFolder folder;
  input::Parameters parameters;
  test::StructuredMesh mesh{test::notched_plate()};
  dynamics::SampleResult result;
  cracks::CrackSurface surface;
  std::vector<cracks::CrackLine> lines;
  cracks::CrackBranches branches;
  std::vector<cracks::SectionCrossing> crossings;
  SampleSummary summary;
  cracks::CrackHistory crack_history;
};

TEST_F(SampleFile, ReadsTheRowThatWasWritten) {
  const fs::path file = sample_path(folder.path() / "out", 3);
  EXPECT_THROW(write(file), std::runtime_error) << "the ensemble's folder is not made";
  fs::create_directory(folder.path() / "out");
  EXPECT_EQ(file, folder.path() / "out/samples/0003.h5");
  write(file);
  const SampleSummary row = read_summary(file, parameters, 3);
  EXPECT_EQ(to_bytes(row), to_bytes(summary));
  EXPECT_EQ(row.wall_time, 10);
  EXPECT_TRUE(std::isfinite(row.position.at(0)));
  EXPECT_TRUE(std::isnan(row.position.at(3)));
  EXPECT_EQ(n_entries(file.parent_path()), 1) << "a partial file is left";
}

TEST_F(SampleFile, HasTheMassThatWasAdded) {
  fs::create_directory(folder.path() / "out");
  const fs::path file = sample_path(folder.path() / "out", 3);
  const std::map<std::string, double> shares{{"added_mass_share", 1e-4},
                                             {"added_mass_share_in_corridor", 2e-3},
                                             {"nodes_with_added_mass_share", 0.03},
                                             {"step_gain", 1.4}};
  for (const bool is_scaled : {false, true}) {
    if (is_scaled) result.mass_scaling = dynamics::MassScaling{1e-4, 2e-3, 0.03, 1.4};
    write(file);
    const hdf5::Handle root = hdf5::open_for_reading(file), row = hdf5::open_group(root, "summary");
    for (const auto& [name, share] : shares) {
      ASSERT_EQ(H5Lexists(row, name.c_str(), H5P_DEFAULT) > 0, is_scaled) << name;
      EXPECT_EQ(is_scaled ? hdf5::read_scalar<double>(row, name) : share, share) << name;
    }
  }
}

TEST_F(SampleFile, NumbersThatNoComputationGivesAreNamed) {
  const fs::path file = sample_path(folder.path(), 3);
  const auto reason = [&] {
    write(file);
    return read_summaries(folder.path(), parameters, 3, 1).front().error;
  };
  const SampleSummary good = summary;
  summary.peak_load = std::numeric_limits<double>::infinity();
  EXPECT_THAT(reason(), ::testing::AllOf(::testing::HasSubstr("0003.h5"),
                                         ::testing::HasSubstr("peak_load is infinite")));
  summary = good;
  summary.position[0] = -std::numeric_limits<double>::infinity();
  EXPECT_THAT(reason(), ::testing::HasSubstr("position is infinite"));
  summary = good;
  parameters.random.emplace_back().key = "mesh.perturbation";
  summary.inputs = {std::nan("")};
  EXPECT_THAT(reason(), ::testing::AllOf(::testing::HasSubstr("0003.h5"),
                                         ::testing::HasSubstr("the random input mesh.perturbation is nan")));
}

TEST_F(SampleFile, IsTheSameForTheSameContentExceptTimingAndProvenance) {
  const fs::path a = folder.path() / "a.h5";
  const fs::path b = folder.path() / "b.h5";
  write(a);
  summary.wall_time = 99;
  result.timings.dynamic = 100;
  write(b);
  EXPECT_THAT(differences(a, b), ::testing::IsEmpty());

  result.energy[1].strain = std::nextafter(0.5, 1);
  summary.onset_time = 0;
  summary.position[2] = 1;
  write(b, 4);
  EXPECT_THAT(differences(a, b), ::testing::ElementsAre("/@sample", "/energy/strain", "/summary/onset_time",
                                                        "/summary/position"));
  write_failed_sample(b, parameters, 3, summary);
  EXPECT_THAT(differences(a, b), ::testing::Contains("/mesh/nodes"));
  EXPECT_THROW(differences(a, folder.path() / "missing.h5"), std::runtime_error);
}

TEST_F(SampleFile, HoldsNoTimesOutsideProvenance) {
  // Written in two different seconds, the files differ only in the time in /provenance.
  const fs::path a = folder.path() / "a.h5";
  const fs::path b = folder.path() / "b.h5";
  write(a);
  std::this_thread::sleep_for(std::chrono::milliseconds(1100));
  write(b);
  // The last 32 bytes are the checksum.
  const std::string first = bytes_of(a).substr(0, fs::file_size(a) - 32);
  const std::string second = bytes_of(b).substr(0, fs::file_size(b) - 32);
  ASSERT_EQ(first.size(), second.size());
  std::vector<std::size_t> places;
  for (std::size_t i = 0; i < first.size(); ++i) {
    if (first[i] != second[i]) places.push_back(i);
  }
  ASSERT_FALSE(places.empty());
  const std::string::size_type text_length = std::string("2012-01-31T12:00:00Z").size();
  std::printf("%zu of %zu bytes differ, within %zu bytes\n", places.size(), first.size(),
              places.back() - places.front() + 1);
  EXPECT_LT(places.back() - places.front(), text_length);
}

TEST_F(SampleFile, HoldsBridgeReleasesWithReleaseByFacets) {
  result.bridge_releases = {{7, 76.18, 1e-6, 2e-9, 9}, {5, 76.18, 2e-6, 1e-9, 34}};
  const fs::path elements = folder.path() / "elements.h5";
  const fs::path facets = folder.path() / "facets.h5";
  write(elements);
  parameters.fracture.release = input::Release::facet;
  write(facets);
  EXPECT_THAT(
      differences(elements, facets),
      ::testing::ElementsAre("/@input_identity", "/bridge_releases", "/bridge_releases/edges",
                             "/bridge_releases/load_time", "/bridge_releases/load_time@units",
                             "/bridge_releases/phase_time", "/bridge_releases/phase_time@units",
                             "/bridge_releases/released_energy", "/bridge_releases/released_energy@units",
                             "/bridge_releases/tetrahedron"));
  EXPECT_EQ(to_bytes(read_summary(facets, parameters, 3)), to_bytes(summary));
}

TEST_F(SampleFile, HoldsTheTeethWithSoftening) {
  result.stiffness_reductions = {{7, 76.18, 1e-6, 2e-9, 0.8, 5}, {7, 76.18, 2e-6, 1e-9, 0.5, 5}};
  const fs::path elements = folder.path() / "elements.h5";
  const fs::path softening = folder.path() / "softening.h5";
  write(elements);
  parameters.fracture.release = input::Release::softening;
  write(softening);
  EXPECT_THAT(differences(elements, softening),
              ::testing::ElementsAre(
                  "/@input_identity", "/softening", "/softening/load_time", "/softening/load_time@units",
                  "/softening/phase_time", "/softening/phase_time@units", "/softening/released_energy",
                  "/softening/released_energy@units", "/softening/share", "/softening/tetrahedron"));
}

TEST_F(SampleFile, HoldsTheHistory) {
  parameters.boundaries.resize(2);
  parameters.boundaries[0].kind = input::BoundaryKind::fix;
  parameters.boundaries[1].on = "z-max";
  parameters.boundaries[1].kind = input::BoundaryKind::force;
  parameters.output.probes = {{"gauge", {1, 2, 3}}};
  for (int i = 0; i < 3; ++i) {
    const double x = i;
    result.history.push_back({.load_time = 10 + x,
                              .phase = i,
                              .energy = {x, 1, 2, 3 + x, 4, 5, i == 2 ? std::ssize(result.breaks) : 0},
                              .load = 7 - x,
                              .load_displacement = x / 8,
                              .force = {{0, 0, -x}, {0, 0, x}},
                              .displacement = {{}, {0, 0, x / 8}},
                              .probes = {{{1, 2, 3}, {x, 0, 0}, {0, 0, x, 0, 0, 0}}},
                              .records = {{"springs", "N", "force of springs", x / 4}}});
  }
  result.loads = {7, 0, 5};
  crack_history = cracks::crack_history(mesh.body(), surface, result,
                                        cracks::front_trajectories(mesh.body(), surface, infinity), infinity);
  summary = analysis::summarize(mesh.body(), result, surface, lines, branches, crossings,
                                cracks::front_trajectories(mesh.body(), surface, rayleigh_speed()));
  EXPECT_EQ(summary.peak_load, 7);
  EXPECT_EQ(summary.displacement_at_peak, 0);
  EXPECT_EQ(summary.work_of_fracture, 5);
  const fs::path file = folder.path() / "a.h5";
  write(file);
  const hdf5::Handle root = hdf5::open_for_reading(file);
  const hdf5::Handle group = hdf5::open_group(root, "history");
  const auto numbers = [&](const char* name, const hdf5::Shape& shape) {
    return hdf5::read_dataset<double>(group, name, shape);
  };
  EXPECT_EQ(numbers("time", {3}), (std::vector<double>{10, 11, 12}));
  EXPECT_EQ(numbers("external", {3}), (std::vector<double>{3, 4, 5}));
  EXPECT_EQ(numbers("governing_load", {3}), (std::vector<double>{7, 6, 5}));
  EXPECT_EQ(numbers("load", {3, 2, 3}).at(17), 2);
  EXPECT_EQ(numbers("load", {3, 2, 3}).at(14), 0) << "a reaction is no load";
  EXPECT_EQ(numbers("reaction", {3, 2, 3}).at(14), -2);
  EXPECT_EQ(numbers("reaction", {3, 2, 3}).at(17), 0);
  EXPECT_EQ(numbers("displacement", {3, 2, 3}).at(11), 0.125);
  EXPECT_EQ(hdf5::read_texts(group, "condition_kind"), (std::vector<std::string>{"fix", "force"}));
  EXPECT_EQ(hdf5::read_texts(group, "condition_on"), (std::vector<std::string>{"z-min", "z-max"}));
  EXPECT_EQ(numbers("probes/gauge/stress", {3, 6}).at(14), 2);
  EXPECT_EQ(numbers("probes/gauge/at", {3}), (std::vector<double>{1, 2, 3}));
  EXPECT_EQ(numbers("terms/springs", {3}), (std::vector<double>{0, 0.25, 0.5}));
  EXPECT_EQ(numbers("crack_area", {3, 2}).at(4), summary.crack_area);
  EXPECT_TRUE(fs::exists(file));
}

TEST_F(SampleFile, CrackSurfaceIsReadBackBitByBit) {
  write(sample_path(folder.path(), 3));
  const StoredSample stored = SampleReader(folder.path(), parameters).whole(3);
  EXPECT_EQ(to_bytes(stored.summary), to_bytes(summary));
  ASSERT_EQ(stored.surface.facets.size(), surface.facets.size());
  ASSERT_GT(surface.facets.size(), 100u);
  for (std::size_t i = 0; i < surface.facets.size(); ++i) {
    const cracks::CrackFacet& a = stored.surface.facets[i];
    const cracks::CrackFacet& b = surface.facets[i];
    EXPECT_EQ(std::tie(a.corner, a.area, a.time, a.tetrahedron, a.crack),
              std::tie(b.corner, b.area, b.time, b.tetrahedron, b.crack));
  }
  ASSERT_EQ(stored.surface.cracks.size(), surface.cracks.size());
  for (std::size_t i = 0; i < surface.cracks.size(); ++i)
    EXPECT_EQ(stored.surface.cracks[i].start, surface.cracks[i].start);

  // The same sections give the same row, others what the run would have found there.
  SampleSummary row = stored.summary;
  row.position.assign(6, -1);
  analysis::measure_crossings(mesh.body(), stored.surface, parameters.sections, row);
  EXPECT_EQ(to_bytes(row), to_bytes(summary));
  const input::Sections others{.y = {5.25, 6.5}, .z = {12}};
  analysis::measure_crossings(mesh.body(), stored.surface, others, row);
  const SampleSummary expected = analysis::summarize(
      mesh.body(), result, surface, lines, branches,
      cracks::section_crossings(mesh.body(), surface, branches, cracks::planes_of(others)),
      cracks::front_trajectories(mesh.body(), surface, rayleigh_speed()));
  EXPECT_EQ(to_bytes(row), to_bytes(expected));
  EXPECT_NE(row.position, summary.position);
}

TEST_F(SampleFile, GivesTheBranchingOfTheRun) {
  result.breaks = mesh.break_between(
      [](const geometry::Point& p) { return p[2] > (p[1] > 6.5 ? 13.5 : 8.5) ? 2
                                            : p[2] > 8.5                     ? 1
                                                                             : 0; },
      [](const geometry::Point& p) { return p[1] > 4 ? p[1] : -1.0; });
  surface = cracks::make_crack_surface(mesh.body(), mesh.realization(), result.breaks, 0);
  branches = cracks::find_branches(mesh.body(), surface);
  crossings =
      cracks::section_crossings(mesh.body(), surface, branches, cracks::planes_of(parameters.sections));
  ASSERT_EQ(branches.points.size(), 1U);
  summary = analysis::summarize(mesh.body(), result, surface, lines, branches, crossings,
                                cracks::front_trajectories(mesh.body(), surface, rayleigh_speed()));
  EXPECT_EQ(summary.branching_points, 1);
  EXPECT_EQ(summary.branching_points_projected, 1);
  EXPECT_EQ(summary.branches, (std::vector<std::int32_t>{1, 2, 2, 0, 0, 0}));
  write(sample_path(folder.path(), 3));
  const StoredSample stored = SampleReader(folder.path(), parameters).whole(3);
  ASSERT_EQ(stored.branching.size(), 1U) << stored.summary.error;
  const cracks::BranchingPoint& found = stored.branching[0];
  const cracks::BranchingPoint& point = branches.points[0];
  const auto numbers = [](const cracks::BranchingPoint& f) {
    return std::vector<double>{f.x, f.y, f.z, f.time, f.length, f.angle, f.share};
  };
  EXPECT_EQ(numbers(found), numbers(point));
  EXPECT_GT(point.time, 4);
  EXPECT_EQ(found.start, 0);
  EXPECT_TRUE(found.is_in_projection);
  EXPECT_TRUE(found.is_in_space);
}

TEST_F(SampleFile, SamplesWithoutResultHaveNoCrackSurface) {
  EXPECT_EQ(SampleReader(folder.path(), parameters).whole(3).summary.status, SampleStatus::pending);
  write_failed_sample(sample_path(folder.path(), 3), parameters, 3,
                      analysis::empty_summary(2, 3, SampleStatus::failed, "reason"));
  const StoredSample failed = SampleReader(folder.path(), parameters).whole(3);
  EXPECT_EQ(failed.summary.error, "reason");
  EXPECT_TRUE(failed.surface.facets.empty());
  write(sample_path(folder.path(), 3), 2);  // contains another number
  const StoredSample refused = SampleReader(folder.path(), parameters).whole(3);
  EXPECT_EQ(refused.summary.status, SampleStatus::pending);
  EXPECT_THAT(refused.summary.error, ::testing::HasSubstr("holds sample 2 instead of 3"));
}

TEST_F(SampleFile, AFailedSampleKeepsItsReason) {
  const fs::path file = folder.path() / "failed.h5";
  const SampleSummary failed = analysis::empty_summary(2, 3, SampleStatus::failed, "tetrahedron 7: µ < 0");
  write_failed_sample(file, parameters, 0, failed);
  const SampleSummary row = read_summary(file, parameters, 0);
  EXPECT_EQ(row.status, SampleStatus::failed);
  EXPECT_EQ(row.error, failed.error);
  EXPECT_EQ(to_bytes(row), to_bytes(failed));
}

TEST_F(SampleFile, EmptyTablesAreWritten) {
  result = {};
  surface = {};
  parameters.specimen.notches.clear();
  parameters.sections.y.clear();
  branches = {};
  crossings.clear();
  summary = analysis::empty_summary(0, 0, SampleStatus::done);
  const fs::path file = folder.path() / "empty.h5";
  write(file);
  EXPECT_EQ(read_summary(file, parameters, 3).status, SampleStatus::done);
}

TEST_F(SampleFile, ForeignFilesAreRefusedWithTheReason) {
  const fs::path file = folder.path() / "a.h5";
  EXPECT_THAT(refusal(file), ::testing::HasSubstr("No such file"));
  put_bytes(file, "no HDF5 here");
  EXPECT_THAT(refusal(file), ::testing::HasSubstr("no checksum at its end"));
  write_ensemble(parallel::Communicator(MPI_COMM_SELF), file, parameters, {},
                 analysis::make_statistics(
                     std::vector(5, analysis::empty_summary(2, 3, SampleStatus::pending)), parameters),
                 {});
  EXPECT_THAT(refusal(file), ::testing::HasSubstr("no checksum at its end"));
  const std::string ensemble = bytes_of(file);
  const auto bytes = std::as_bytes(std::span(ensemble));
  write_checked_file(file, {bytes.begin(), bytes.end()});
  EXPECT_THAT(refusal(file), ::testing::HasSubstr("not a crackle sample file"));
  write(file);
  EXPECT_EQ(refusal(file), "not refused");
  EXPECT_THAT(refusal(file, 4), ::testing::HasSubstr("holds sample 3 instead of 4"));
  parameters.text += " ";
  parameters.ensemble.samples = 7;
  EXPECT_EQ(refusal(file), "not refused") << "the same sample of a larger ensemble";
  parameters.mesh.growth = 0.1 * (1 + 1e-14);
  EXPECT_THAT(refusal(file), ::testing::AllOf(::testing::HasSubstr(file.string()),
                                              ::testing::HasSubstr("made from another input")));
  write(file);
  parameters.mesh.points_digest = "2 bytes, FNV-1a 07";
  EXPECT_THAT(refusal(file), ::testing::HasSubstr("made from other points (none, not 2 bytes, FNV-1a 07)"));
  write(file);
  parameters.sections.y.pop_back();
  EXPECT_THAT(refusal(file), ::testing::HasSubstr("made from another input"));
}

TEST(Schema, IsRaisedWithTheColumns) {
  std::map<std::int64_t, std::string> names;  // by the first version that has them
  const auto add = [&](const analysis::ResultInfo& info, auto) {
    names[info.since] += std::string(info.name) + " ";
  };
  analysis::for_each_result(add);
  analysis::for_each_position_result(add);
  add(analysis::crack_area_in_info, 0);
  EXPECT_EQ(names[4],
            "first_break_time first_break_load onset_time onset_force peak_load displacement_at_peak "
            "work_of_fracture dynamic_phases crack_area_before_onset outcome pattern leading_notch overlap "
            "bifurcations bifurcations_projected kinks breaks crack_area crack_speed_max crack_speed_ratio "
            "traced_area effective_toughness energy_error equilibrium_residual position z_spread "
            "arrival_time branches ")
      << "other columns are of a new version";
  EXPECT_EQ(names[5], "first_break_x first_break_y first_break_z ");
  EXPECT_EQ(names[6], "hole hole_passage crack_area_in ");
  EXPECT_EQ(names[7], "long_bifurcations ");
  EXPECT_EQ(names[8], "held ");
  EXPECT_EQ(names.rbegin()->first, sample_schema_version);
  EXPECT_EQ(sample_schema_version, ensemble_schema_version);
}

TEST(OlderFormat, ThePapersStoredEnsembleIsRead) {
  const EnsembleContent ensemble =
      read_ensemble(fs::path(CRACKLE_SOURCE_DIR) / "jobs/paper/shared-base/ensemble.h5");
  EXPECT_EQ(ensemble.samples.size(), 200U);
  EXPECT_NEAR(ensemble.samples[0].onset_force, 512, 40);
}

TEST_F(SampleFile, TruncatedAndDamagedFilesAreRefused) {
  const fs::path file = folder.path() / "a.h5";
  write(file);
  const std::string whole = bytes_of(file);
  for (const std::size_t size : {std::size_t{0}, std::size_t{20}, whole.size() / 2, whole.size() - 1}) {
    put_bytes(file, whole.substr(0, size));
    EXPECT_NE(refusal(file), "not refused") << size << " of " << whole.size() << " bytes";
  }
}

TEST_F(SampleFile, OneBitFlippedAnywhereIsNoticed) {
  const fs::path file = folder.path() / "a.h5";
  write(file);
  const std::string whole = bytes_of(file);
  // All bytes of both ends, and those at a prime stride in between.
  int n_flips = 0;
  for (std::size_t i = 0; i < whole.size(); i += i < 600 || i + 100 > whole.size() ? 1 : 149) {
    std::string damaged = whole;
    damaged[i] = static_cast<char>(damaged[i] ^ (1 << i % 8));
    put_bytes(file, damaged);
    ++n_flips;
    EXPECT_THROW(read_summary(file, parameters, 3), std::runtime_error) << "byte " << i;
  }
  int n_cuts = 0;
  for (std::size_t size = whole.size() % 1511; size < whole.size(); size += 1511) {
    put_bytes(file, whole.substr(0, size));
    ++n_cuts;
    EXPECT_THROW(read_summary(file, parameters, 3), std::runtime_error) << size << " bytes";
  }
  std::printf("%d of %d flipped bits and %d of %d cuts of %zu bytes noticed\n", n_flips, n_flips, n_cuts,
              n_cuts, whole.size());
}

TEST_F(SampleFile, UnwritablePlacesAreErrorsThatNameTheFile) {
  put_bytes(folder.path() / "plain", "a file, not a folder");
  const fs::path file = folder.path() / "plain/0003.h5";
  try {
    write(file);
    ADD_FAILURE() << "no error";
  } catch (const std::runtime_error& error) {
    std::printf("%s\n", error.what());
    EXPECT_THAT(error.what(), ::testing::AllOf(::testing::HasSubstr("'" + file.string() + "'"),
                                               ::testing::HasSubstr("Not a directory")));
  }
}

TEST_F(SampleFile, AFullDiskLeavesTheOldFileAndNoPart) {
  const fs::path file = folder.path() / "a.h5";
  write_failed_sample(file, parameters, 3, analysis::empty_summary(2, 3, SampleStatus::failed, "old"));
  // A file size limit interrupts a write, like a full disk.
  rlimit old_limit{};
  ASSERT_EQ(getrlimit(RLIMIT_FSIZE, &old_limit), 0);
  const rlimit limit{20'000, old_limit.rlim_max};
  const auto old_handler = std::signal(SIGXFSZ, SIG_IGN);
  ASSERT_EQ(setrlimit(RLIMIT_FSIZE, &limit), 0);
  std::string message;
  try {
    write(file);
  } catch (const std::runtime_error& error) {
    message = error.what();
  }
  setrlimit(RLIMIT_FSIZE, &old_limit);
  std::signal(SIGXFSZ, old_handler);
  std::printf("%s\n", message.c_str());
  EXPECT_THAT(message, ::testing::HasSubstr("File too large"));
  EXPECT_EQ(n_entries(folder.path()), 1);
  EXPECT_EQ(read_summary(file, parameters, 3).error, "old");
}

TEST_F(SampleFile, ContentThatDoesNotFitTogetherIsAnErrorAndLeavesNoFile) {
  result.frames[1].velocity.pop_back();
  const fs::path file = folder.path() / "a.h5";
  EXPECT_THROW(write(file), std::runtime_error);
  EXPECT_EQ(n_entries(folder.path()), 0);
}

TEST_F(SampleFile, SummariesOfAFolderAreCompleteWithPendingRows) {
  write(sample_path(folder.path(), 1), 1);
  write_failed_sample(sample_path(folder.path(), 2), parameters, 2,
                      analysis::empty_summary(2, 3, SampleStatus::failed, "reason"));
  write(sample_path(folder.path(), 3), 2);  // contains another number
  const auto rows = read_summaries(folder.path(), parameters, 1, 4);
  ASSERT_EQ(rows.size(), 4u);
  EXPECT_EQ(rows[0].status, SampleStatus::done);
  EXPECT_EQ(rows[1].status, SampleStatus::failed);
  EXPECT_EQ(rows[1].error, "reason");
  EXPECT_EQ(rows[2].status, SampleStatus::pending);
  EXPECT_THAT(rows[2].error, ::testing::HasSubstr("holds sample 2 instead of 3"));
  EXPECT_EQ(rows[3].status, SampleStatus::pending);
  EXPECT_EQ(rows[3].error, "");
}

}  // namespace CRACKLE_TEST_FILE
}  // namespace crackle::io
