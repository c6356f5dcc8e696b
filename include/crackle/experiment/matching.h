// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "crackle/experiment/group_test.h"
#include "crackle/experiment/observation.h"
#include "crackle/experiment/rank_test.h"
#include "crackle/input/parameters.h"

#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <vector>

namespace crackle::experiment {

/// Level of tests, and of what is said about them.
inline constexpr double match_level = 0.05;
/// Number of nearest samples that are told.
inline constexpr std::size_t n_nearest = 5;
/// Pseudo-experiments for the power of the tests of a set.
inline constexpr int n_power_trials = 200;

/// A sample by its number and its distance from the experiment.
struct Neighbour {
  std::uint64_t sample;
  double distance;  ///< in the quantity's unit
};

/// An experiment beside the samples, by one quantity or by all of them.
struct MatchBy {
  std::string name;  ///< of the quantity, or "jointly"
  std::string unit;  ///< SI; "1" of joint distances, where each quantity counts in its own scatter
  double p_value = not_a_number;         ///< NaN without samples
  std::size_t n_samples = 0;             ///< that count
  std::vector<std::uint64_t> left_out;   ///< samples without the quantity
  std::vector<Neighbour> nearest;        ///< the nearest one first
  double mean_distance = not_a_number;   ///< of the experiment to the samples
  double usual_distance = not_a_number;  ///< median of the samples' mean distances to all others
  /// Mean over the stations of the experiment less the samples' mean, and the standard deviation of the same
  /// of the samples; NaN jointly, and of times of tips.
  double offset = not_a_number, deviation = not_a_number;
};

/// A part of a path outside the band of the samples.
struct Departure {
  plane::Point from{}, to{};     ///< on the middle of the samples [m]
  double beyond = not_a_number;  ///< the band, signed along the normals [m]; NaN if the crack ended before
};

/// The path of an experiment in that of the samples, at the stations of a frame.
struct PathMatch {
  PathFrame frame;
  std::vector<double> offset = {};          ///< of the experiment
  std::vector<std::uint64_t> samples = {};  ///< by number
  std::vector<std::uint64_t> turned = {};   ///< those whose paths are turned by a symmetry of the body
  ValueTable of_samples = {};               ///< their offsets, as computed
  Envelope band = {};
  std::vector<Departure> departures = {};
};

struct ExperimentMatch {
  std::string name = {};
  std::vector<MatchBy> by = {};   ///< the last one is "jointly" if there are several
  double p_value = not_a_number;  ///< of the last one
  std::optional<PathMatch> path = {};
  std::string note = {};  ///< why something could not be compared; may be empty
};

/// Several experiments beside the samples.
struct SetMatchBy {
  std::string name, unit;  ///< as in MatchBy
  std::size_t n_experiments = 0, n_samples = 0;
  GroupTest test;
  Power power;              ///< not jointly
  Scatter scatter;          ///< not jointly
  std::string axis = {};    ///< of the shift of paths: "y" or "z"
  std::string advice = {};  ///< what follows from shift and scatter, in sentences
};

struct SetMatch {
  std::size_t n_experiments = 0;  ///< the most in one comparison
  std::vector<SetMatchBy> by;  ///< the last one is "jointly" if several quantities have experiments in common
  double p_value = not_a_number;  ///< of that, or the least one times their number (Bonferroni)
};

struct Match {
  std::vector<ExperimentMatch> experiments = {};
  std::optional<SetMatch> set = {};  ///< with two experiments or more that have something in common
  std::vector<std::string> warnings = {};
  std::size_t n_planned = 0, n_used = 0;
  std::vector<std::uint64_t> failed = {}, undecided = {}, missing = {};
};

/// Holds one experiment against the samples. The same in each call.
ExperimentMatch match_one(const Experiment& experiment, const ObservedSamples& samples,
                          const geometry::Body& body);

/// Holds experiments against the samples of an ensemble. The same in each call.
/// @param parameters of the ensemble, for warnings
Match match(std::span<const Experiment> experiments, const ObservedSamples& samples,
            const geometry::Body& body, const input::Parameters& parameters);

/// Sentences on the shift and scatter of experiments: their meaning for the model.
std::string advice(const SetMatchBy& by);

/// The match as readable tables and sentences.
std::string to_text(const Match& match);

/// The same as a JSON document in SI units, with what was observed and the samples' loads; NaN is null.
std::string to_json(const Match& match, std::span<const Experiment> experiments,
                    const ObservedSamples& samples);

/// An experiments file to start from, with all keys explained and values of this ensemble.
/// @param folder of the ensemble, for the explanations
std::string experiments_template(const ObservedSamples& samples, const geometry::Body& body,
                                 const input::Parameters& parameters, const std::string& folder);

}  // namespace crackle::experiment
