// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "crackle/analysis/sample_summary.h"
#include "crackle/cracks/crack_surface.h"
#include "crackle/experiment/distances.h"
#include "crackle/experiment/experiments_file.h"
#include "crackle/experiment/path_frame.h"
#include "crackle/geometry/body.h"

#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <vector>

/// A sample's results that correspond to observations in an experiment.
namespace crackle::experiment {

/// A crack's main arm and when it arrived at its points.
struct TimedLine {
  Polyline points;
  std::vector<double> time;  ///< since the start of the last dynamic phase [s]
  bool is_turned = false;    ///< by a symmetry of the body
};

/// One sample that is done.
struct ObservedSample {
  std::uint64_t number = 0;
  analysis::SampleSummary summary = {};
  /// For each crack start of the body, the arms that an experiment's crack from there is compared with; see
  /// main_arms. Empty if there are none, or paths are not needed.
  std::vector<std::vector<TimedLine>> arms = {};
};

/// The samples of an ensemble, and those that do not count, by number.
struct ObservedSamples {
  std::vector<ObservedSample> samples = {};
  std::vector<geometry::Symmetry> symmetries = {};  ///< of the body and its loads
  std::size_t n_planned = 0;
  std::uint64_t seed = 0;
  std::vector<std::uint64_t> failed = {}, undecided = {}, missing = {};
};

/// Sorts the rows of an ensemble: samples that are done and decided count.
ObservedSamples sort_samples(std::span<const analysis::SampleSummary> rows, std::uint64_t seed);

/// Adds the arms of a sample's crack.
///
/// For a start with a ligament this is the main line (crack_lines) of the leading crack, turned onto the
/// start by one of the symmetries; if there is none, that of the start itself. For another start
/// these are the main lines of all its ligaments and, if two of them begin at one place inside the body, both
/// as one.
/// @param symmetries of the body and its loads
void add_arms(const geometry::Body& body, const std::vector<geometry::Symmetry>& symmetries,
              const cracks::CrackSurface& surface, ObservedSample& sample);

/// True if the arms of the samples are needed.
bool needs_arms(std::span<const Experiment> experiments);

/// The crack start nearest to an end of the main arm: the tip of a notch with a ligament, else a wall; the
/// free surface only if an end of the arm is nearer to it than to any other start. Without a path, the start
/// whose ligament or wall is nearest to the first tip. -1 if the body has none.
int crack_start_of(const geometry::Body& body, const Experiment& experiment);

/// Refuses paths and tips that lie elsewhere than the body.
/// @throws input::InputError naming all experiments concerned
void check_places(const std::filesystem::path& file, std::span<const Experiment> experiments,
                  const geometry::Body& body);

enum class Quantity { path, onset_load, peak_load, tip_times };
/// "onset_load"
const char* name_of(Quantity quantity);

/// A sample's load that corresponds to a measured `onset_load` or `peak_load`; NaN if it has none.
double load_of(const analysis::SampleSummary& row, Quantity quantity);

/// A quantity of experiments and of samples alike.
struct Observable {
  Quantity quantity{};
  std::string unit = {};  ///< SI
  double error = 0;  ///< of reading or measuring in the experiments: standard deviation, in their mean square
  double error_length = 0;  ///< correlation length of that error along paths, in their mean [m]
  std::vector<std::size_t> experiments = {};  ///< those that have it
  std::vector<std::size_t> samples = {};      ///< indices of those that have it
  ValueTable of_experiments = {};             ///< a row for each
  ValueTable of_samples = {};                 ///< as computed
  ValueTable with_error = {};                 ///< of samples, as if they had been read or measured
  std::optional<PathFrame> frame = {};        ///< of paths
  std::vector<std::size_t> turned = {};       ///< samples whose paths are turned by a symmetry of the body
};

/// True if two loads are one quantity in the samples, such as onset and peak of cracks that do not stop:
/// their correlation is above 0.999. @pre the same samples have them
bool is_same_load(const Observable& one, const Observable& other);

/// Everything that any of the experiments has, with the samples seen as the experiments were: through the
/// same window, with errors of the same size. Times of tips only for a single experiment, since others have
/// their own places. Paths from other crack starts than the first experiment's are turned onto that by a
/// symmetry of the body, or left out if it has none.
///
/// Loads: `onset_load` is the sample's onset_force or, without quasi-static loading, its first_break_load;
/// `peak_load` is peak_load. Samples that lack them are left out. Paths: offsets along the stations of a
/// path_frame. Tips: when the crack came to the nearest point of its path, 0 if it was there before it ran
/// away; NaN if it ended before.
/// @param stream of the random errors, to be different for each call
std::vector<Observable> observe(std::span<const Experiment> experiments, const ObservedSamples& samples,
                                const geometry::Body& body, std::uint64_t stream);

}  // namespace crackle::experiment
