// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "analysis/sample_summary.h"
#include "cracks/crack_history.h"
#include "cracks/crack_line.h"
#include "cracks/crack_surface.h"
#include "dynamics/sample_result.h"
#include "geometry/realization.h"
#include "input/parameters.h"

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
/// | /pre_cracks/tetrahedron, cut, crack | p | open from the start, with pre-cracks: geometry::PreCrackCut |
/// | /pre_cracks/flaws/center, normal, radius | q x 3, 3, q | the sample's random flaws |
/// | /mesh/nodes, tetrahedra | n x 3, m x 4 | the realization; attributes of /mesh: its report |
/// | /mesh/boundary, boundary_surface | k x 3, k | boundary triangles and their geometry::SurfaceId |
/// | /mesh/material, strength_factor, map_factor | m | of each tetrahedron, if they differ |
/// | /mesh/youngs_modulus, poisson_ratio, density, release_time | m | likewise |
/// | attributes material_names, map of / | | of several materials; checksum of the sample's own raster |
/// | /mesh/initial_strain | m x 6 | of the last dynamic phase, with [[initial.stress]] |
/// | /crack_surface/corners | f x 4 x 3 | opened dual facets, in order of breaking |
/// | /crack_surface/time, area, tetrahedron, crack | f | see cracks::CrackFacet |
/// | /crack_surface/branch | f | of plates: see cracks::CrackBranches |
/// | /crack_surface/cracks/notch, hole, area, first_time, last_time | c | see cracks::Crack |
/// | /crack_surface/cracks/lower, upper | c x 3 | its bounding box, unless the body is a plate |
/// | /crack_lines/position (y, z), spread, time | p x 2, p | points of all lines, see cracks::LinePoint |
/// | /crack_lines/lines/first, count | l | the points of each line |
/// | /crack_lines/lines/notch, parent, kinks, bend | l | see cracks::CrackLine |
/// | /forks/position (y, z), x, time, length, angle, share, notch, in_projection, in_space | k x 2, k | see
/// cracks::BranchingPoint |
/// | /crossings/position, share, branch, notch, section | q | see cracks::BranchCrossing |
/// | /plane_traces/plane, crack, notch, length, position, time | l | see cracks::PlaneTrace |
/// | /breaks/... | b | the columns of fracture::Break |
/// | /bridge_releases/... | r | the columns of fracture::BridgeRelease; with release by facets only |
/// | /energy/... | e | the columns of dynamics::EnergyRow |
/// | /history/time, phase, phase_time, governing_load, kinetic, ... | h | see dynamics::HistoryRow |
/// | /history/crack_area, crack_length, tip_speed, ... | h x starts | see cracks::CrackHistory |
/// | /history/cracks/area, reach, speed | h x c | cracks::CracksInSpace |
/// | /history/load, reaction, displacement | h x c x 3 | of each boundary condition |
/// | /history/condition_on, condition_kind | c | the input's boundary conditions, then its body forces |
/// | /history/probes/NAME/displacement, velocity, stress | h x 3, 3, 6 | see dynamics::ProbeValue |
/// | /history/probes/NAME/at | 3 | place of the probe |
/// | /history/terms/NAME | h | see dynamics::Record |
/// | attributes of /tools/NAME | | shape, at, axis, radius, size, rounding, mass [SI] |
/// | /history/tools/NAME/position, displacement, velocity, reaction, friction_work | h x 3, h | see
/// dynamics::ToolState |
/// | /history/tools/NAME/orientation, angular_velocity | h x 4, h x 3 | likewise, of a tool that can turn |
/// | attribute rayleigh_speed [m/s] of /history | | of the material in which the cracks ran |
/// | /frames/time, broken | t | see dynamics::Frame |
/// | /frames/displacement, velocity | t x n x 3 | single precision |
/// | /fragments/mass, share, volume, nodes, first_node, center, velocity, kinetic, kinetic_of_mean, extent,
/// frozen | g, of vectors g x 3 | at the end, the heaviest first: see dynamics::Fragment |
/// | /fragments/of_node | n | row of each node; -1: dust |
/// | /fragments/dust/nodes, mass, volume, kinetic | | single nodes, which have no row |
/// | /fragments/history/time, number, ... | i | see dynamics::FragmentCount |
/// | attributes youngs_modulus [Pa], poisson_ratio of /frames | | for computing the stress; of broken
/// tetrahedra also from /breaks/cut, /bridge_releases and the input |
/// | attribute release_time [s] of /frames | | of what falls at the time of a frame |
/// | /summary/... | | the row: analysis::for_each_result, for_each_position_result |
/// | /summary/crack_area_in | p | analysis::crack_area_in_info; attribute parts: analysis::crack_parts |
/// | /summary/traces/length, along, across, time | t | with [[sections.plane]]: cracks::start_traces |
/// | /summary/fragments/... | | analysis::for_each_fragment_result |
/// | /summary/fragments/heavier, shares | d | analysis::FragmentSummary; analysis::fragment_shares |
/// | /summary/phase_start | | load time at time zero of cracks and frames |
/// | /summary/time_step, stable_step | | steps |
/// | /summary/added_mass_share, added_mass_share_in_corridor, nodes_with_added_mass_share, step_gain | | with
/// time.mass_scaling: dynamics::MassScaling |
/// | /counts/... | | dynamics::SampleCounts |
/// | /timing/..., attributes of /provenance | | what differs between two runs |
///
/// A checksum of all bytes follows the end of the HDF5 file: a truncated, damaged or modified file is
/// rejected.
///
/// A failed sample has the attributes, /summary, /timing and /provenance, and whatever else was available
/// when it failed.
namespace crackle::io {

/// Incremented with every change of the file's contents.
inline constexpr std::int64_t sample_schema_version = 8;

/// Oldest version of sample and ensemble files whose results can still be read, that of version 1.0.0 of the
/// program; samples cannot continue from them.
inline constexpr std::int64_t oldest_schema_version = 4;

/// Incremented with every change that affects the results of some inputs: samples of different models cannot
/// belong to one ensemble. Files without it are of model 1.
inline constexpr std::int64_t model_version = 9;

/// The first model in which samples have base points of their own if the input does not say; before, they
/// shared one set.
inline constexpr std::int64_t first_model_of_own_bases = 5;

/// A complete file written by a program version whose samples are incompatible with those of this one.
class OlderFormat : public std::runtime_error {
public:
  using std::runtime_error::runtime_error;
};

/// Contents of out/samples/NNNN.h5.
struct SampleFileContent {
  const input::Parameters& parameters;
  std::uint64_t sample;
  const geometry::Realization& realization;
  const dynamics::SampleResult& result;
  const cracks::CrackSurface& surface;
  const std::vector<cracks::CrackLine>& lines;
  const cracks::CrackBranches& branches;
  const std::vector<cracks::SectionCrossing>& crossings;  ///< notches x sections
  const analysis::SampleSummary& summary;
  const cracks::CrackHistory& crack_history;
  int n_ranks = 1;  ///< that computed the sample; for /provenance
};

/// out/samples/NNNN.h5 for folder = out
std::filesystem::path sample_path(const std::filesystem::path& folder, std::uint64_t sample);

/// Writes the file under a temporary name, flushes it and renames it when complete; creates its folder if
/// missing. Not collective.
/// @throws std::runtime_error naming the file when anything cannot be written; no partial file is left
void write_sample(const std::filesystem::path& file, const SampleFileContent& content);

/// As write_sample, for a sample that failed: identity, status and reason only.
void write_failed_sample(const std::filesystem::path& file, const input::Parameters& parameters,
                         std::uint64_t sample, const analysis::SampleSummary& summary);

/// The sample's row. @throws OlderFormat for a complete file of an older version or another model;
/// std::runtime_error with the reason when the file is not a complete, undamaged sample file of this number
/// and input (input::sample_identity)
analysis::SampleSummary read_summary(const std::filesystem::path& file, const input::Parameters& parameters,
                                     std::uint64_t sample);

/// The text of the input from which a sample was computed. @throws std::runtime_error naming the file
std::string read_input_text(const std::filesystem::path& file);

/// A sample as stored in its file.
struct StoredSample {
  analysis::SampleSummary summary;
  cracks::CrackSurface surface;                   ///< without facets unless the sample is done
  std::vector<cracks::BranchingPoint> branching;  ///< without `parent`
};

/// Reads the samples of an ensemble's folder, also those of an older format, down to oldest_schema_version:
/// their inputs are not compared, and results that they lack are as in a row without results. Not collective.
///
/// A sample without a file is pending; so is one with an unusable file, with the reason in `error`. A file of
/// another model than the first whole one is unusable: its results are not of this ensemble.
class SampleReader {
public:
  /// `parameters` must outlive the object.
  SampleReader(std::filesystem::path folder, const input::Parameters& parameters);

  analysis::SampleSummary row(std::uint64_t sample) const;
  /// With its crack surface, bitwise as computed.
  StoredSample whole(std::uint64_t sample) const;

private:
  template <class Read>
  analysis::SampleSummary row_or_reason(std::uint64_t sample, const Read& read) const;

  std::filesystem::path folder_;
  const input::Parameters* parameters_;
  std::int64_t model_;
};

/// The rows of samples first, first + 1, ... first + count - 1 of an ensemble's folder, as SampleReader.
std::vector<analysis::SampleSummary> read_summaries(const std::filesystem::path& folder,
                                                    const input::Parameters& parameters, std::uint64_t first,
                                                    std::size_t count);

/// The oldest version of the files in an ensemble's folder; the current one if there are none. Not
/// collective.
std::int64_t format_version(const std::filesystem::path& folder);

/// The model of the samples in an ensemble's folder: that of the first whole file, as runs never mix them.
/// Without samples that of this program, or 0 for an ensemble file of an older version. Not collective.
std::int64_t stored_model(const std::filesystem::path& folder);

/// Refuses a folder with samples of an older format or another model. Checks a single file, as runs never mix
/// them. Not collective.
/// @throws OlderFormat naming the file
void check_model(const std::filesystem::path& folder);

/// True if the folder contains an ensemble or sample file of an older version. Not collective.
inline bool holds_older_format(const std::filesystem::path& folder) {
  return format_version(folder) < sample_schema_version;
}

}  // namespace crackle::io
