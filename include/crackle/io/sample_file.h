// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "crackle/analysis/crack_history.h"
#include "crackle/analysis/crack_line.h"
#include "crackle/analysis/crack_surface.h"
#include "crackle/analysis/sample_summary.h"
#include "crackle/dynamics/sample_result.h"
#include "crackle/geometry/realization.h"
#include "crackle/input/parameters.h"

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <stdexcept>
#include <string>
#include <vector>

/// Sample files, out/samples/NNNN.h5. All values are SI; `units` is an attribute of each dataset.
///
/// | object | shape | meaning |
/// |---|---|---|
/// | attributes of / | | kind, schema_version, model_version, program_version, git_commit, library_versions,
/// input, points, input_identity, engine, same_bits, seed, sample, status, error, note |
/// | /specimen/... | | see geometry::for_each_member |
/// | /mesh/nodes, tetrahedra | n x 3, m x 4 | the realization; attributes of /mesh: its report |
/// | /mesh/boundary, boundary_surface | k x 3, k | boundary triangles and their geometry::SurfaceId |
/// | /crack_surface/corners | f x 4 x 3 | opened dual facets, in order of breaking |
/// | /crack_surface/time, area, tetrahedron, crack | f | see analysis::CrackFacet |
/// | /crack_surface/arm | f | see analysis::CrackArms |
/// | /crack_surface/cracks/notch, area, first_time, last_time | c | see analysis::Crack |
/// | /crack_lines/position (y, z), spread, time | p x 2, p | points of all lines, see analysis::LinePoint |
/// | /crack_lines/lines/first, count | l | the points of each line |
/// | /crack_lines/lines/notch, parent, kinks, bend | l | see analysis::CrackLine |
/// | /forks/position (y, z), x, time, length, angle, share, notch, in_projection, in_space | k x 2, k | see
/// analysis::Fork |
/// | /crossings/position, share, arm, notch, section | q | see analysis::ArmCrossing |
/// | /breaks/... | b | the columns of fracture::Break |
/// | /ties/... | r | the columns of fracture::BridgeRelease; with release by facets only |
/// | /energy/... | e | the columns of dynamics::EnergyRow |
/// | /history/time, phase, phase_time, governing_load, kinetic, ... | h | see dynamics::HistoryRow |
/// | /history/crack_area, crack_length, tip_speed, ... | h x starts | see analysis::CrackHistory |
/// | /history/load, reaction, displacement | h x c x 3 | of each boundary condition |
/// | /history/condition_on, condition_kind | c | the input's boundary conditions |
/// | /history/probes/NAME/displacement, velocity, stress | h x 3, 3, 6 | see dynamics::ProbeValue |
/// | /history/probes/NAME/at | 3 | place of the probe |
/// | attribute rayleigh_speed [m/s] of /history | | of the material |
/// | /frames/time, broken | t | see dynamics::Frame |
/// | /frames/displacement, velocity | t x n x 3 | single precision |
/// | attributes youngs_modulus [Pa], poisson_ratio of /frames | | what the stress follows from; of broken
/// tetrahedra also from /breaks/cut, /ties and the input |
/// | /summary/... | | the row: analysis::for_each_result, for_each_position_result |
/// | /summary/phase_start | | load time that the times of cracks and frames are counted from |
/// | /summary/time_step, stable_step | | steps |
/// | /counts/... | | dynamics::SampleCounts |
/// | /timing/..., attributes of /provenance | | what differs between two runs |
///
/// Behind the end of the HDF5 file stands a check sum of all its bytes: a file that was cut short, damaged or
/// changed afterwards is not used.
///
/// A failed sample has the attributes, /summary, /timing and /provenance, and of the rest what there was when
/// it failed on its way.
namespace crackle::io {

/// Raised with every change of what the file holds.
inline constexpr std::int64_t sample_schema_version = 5;

/// Of the files, samples' and ensembles', whose results can still be read; no sample continues from them.
inline constexpr std::int64_t oldest_schema_version = 2;

/// Raised with every change that moves the results of some inputs: samples of different models are not parts
/// of one ensemble. Files without it are of model 1.
inline constexpr std::int64_t model_version = 2;

/// A whole file that a version of the program wrote whose samples do not go together with those of this one.
class OlderFormat : public std::runtime_error {
public:
  using std::runtime_error::runtime_error;
};

/// Everything that goes into out/samples/NNNN.h5.
struct SampleFileContent {
  const input::Parameters& parameters;
  std::uint64_t sample;
  const geometry::Realization& realization;
  const dynamics::SampleResult& result;
  const analysis::CrackSurface& surface;
  const std::vector<analysis::CrackLine>& lines;
  const analysis::CrackArms& arms;
  const std::vector<analysis::SectionCrossing>& crossings;  ///< notches x sections
  const analysis::SampleSummary& summary;
  const analysis::CrackHistory& crack_history;
  int n_ranks = 1;  ///< that computed the sample; for /provenance
};

/// out/samples/NNNN.h5 for folder = out
std::filesystem::path sample_path(const std::filesystem::path& folder, std::uint64_t sample);

/// Writes the file under another name, flushes it and renames it when it is whole; makes its folder when it
/// is missing. Not collective.
/// @throws std::runtime_error naming the file when anything cannot be written; no partial file is left
void write_sample(const std::filesystem::path& file, const SampleFileContent& content);

/// As write_sample, for a sample that failed: identity, status and reason only.
void write_failed_sample(const std::filesystem::path& file, const input::Parameters& parameters,
                         std::uint64_t sample, const analysis::SampleSummary& summary);

/// The sample's row. @throws OlderFormat for a whole file of an older version or another model;
/// std::runtime_error with the
/// reason when the file is not a whole, undamaged sample file of this number and input
/// (input::sample_identity)
analysis::SampleSummary read_summary(const std::filesystem::path& file, const input::Parameters& parameters,
                                     std::uint64_t sample);

/// As read_summary, of oldest_schema_version and above. What an older file does not have yet is as in a row
/// without results, and an older file's input is not compared.
analysis::SampleSummary read_any_summary(const std::filesystem::path& file,
                                         const input::Parameters& parameters, std::uint64_t sample);

/// The input that a sample was made from, as text. @throws std::runtime_error as read_any_summary
std::string read_input_text(const std::filesystem::path& file);

/// The rows of samples first, first + 1, ... first + count - 1 of an ensemble's folder. A sample without file
/// is pending; so is one whose file cannot be used, with the reason in `error`. Not collective.
std::vector<analysis::SampleSummary> read_summaries(const std::filesystem::path& folder,
                                                    const input::Parameters& parameters, std::uint64_t first,
                                                    std::size_t count);

/// A sample as its file holds it.
struct StoredSample {
  analysis::SampleSummary summary;
  analysis::CrackSurface surface;     ///< without facets unless the sample is done
  std::vector<analysis::Fork> forks;  ///< none of files of version 2, which do not have them
};

/// As read_summaries, of one sample with its crack surface, which is that of the run bit by bit. Not
/// collective.
StoredSample read_stored_sample(const std::filesystem::path& folder, const input::Parameters& parameters,
                                std::uint64_t sample);

/// The oldest version of the files of an ensemble's folder; the present one where it holds none. Not
/// collective.
std::int64_t format_version(const std::filesystem::path& folder);

/// Refuses a folder with samples of an older format or another model. One file stands for all, as no run
/// mixes them. Not collective.
/// @throws OlderFormat naming the file
void check_model(const std::filesystem::path& folder);

/// Whether the folder holds an ensemble's or a sample's file of an older version. Not collective.
inline bool holds_older_format(const std::filesystem::path& folder) {
  return format_version(folder) < sample_schema_version;
}

}  // namespace crackle::io
