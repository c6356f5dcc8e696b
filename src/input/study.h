// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "input/model.h"
#include "input/section.h"

#include <array>
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

/// An ensemble of samples and what is measured of it. All values are in SI units.
namespace crackle::input {

struct EnsembleStop {
  double half_width;  ///< of the confidence interval of the leaders' mean position, at every section [m]
  double confidence;
  int min_samples;
};

/// Which ranks make the realizations of a parallel run. The results are bitwise equal.
enum class MeshMakers {
  automatic,  ///< the master, ahead of need; a group makes its own if none is ready
  master,
  groups,  ///< each group its own
};

/// Sampling plan of the random inputs.
enum class SamplingPlan {
  independent,      ///< at random
  latin_hypercube,  ///< one in each of equally many layers of every input
  sobol,            ///< Sobol sequence with a random digital shift
};
/// As spelled in the input.
inline constexpr std::array plan_names{"independent", "latin-hypercube", "sobol"};

struct Ensemble {
  int samples = 1;
  int ranks_per_sample = 1;
  MeshMakers meshes = MeshMakers::automatic;
  SamplingPlan plan = SamplingPlan::independent;
  int replicates = 1;  ///< number of meshes for each draw of the random inputs
  std::optional<EnsembleStop> stop = {};

  /// The draw of the random inputs used by a sample.
  std::uint64_t input_of(std::uint64_t sample) const {
    return sample / static_cast<std::uint64_t>(replicates);
  }
  /// Number of draws; the last one may have fewer meshes.
  std::uint64_t n_inputs() const { return input_of(static_cast<std::uint64_t>(samples) - 1) + 1; }
};

enum class RandomDistribution {
  normal,
  lognormal,
  uniform,
  triangular,
  weibull,
  beta,
  truncated,
  discrete,   ///< some values
  empirical,  ///< like measured values, linear between them
};
/// As spelled in the input.
inline constexpr std::array distribution_names{"normal", "lognormal", "uniform",  "triangular", "weibull",
                                               "beta",   "truncated", "discrete", "empirical"};

/// A number of the input that changes with another one, such as the far end of a support that is moved.
struct MovedNumber {
  std::string key = {};
  double own = 0;         ///< value in the input itself [SI]
  std::string unit = {};  ///< as RandomInput::unit
};

/// A number of the input that varies between samples. Parameters of the distribution are in the SI unit of
/// that number; NaN: not given.
struct RandomInput {
  std::string key = {};                 ///< "material.youngs_modulus", "specimen.notch[0].depth"
  std::string unit = {};                ///< SI unit; empty for a dimensionless number
  double own = 0;                       ///< value in the input itself
  std::vector<MovedNumber> moved = {};  ///< change with it, by the same amount or factor
  bool by_factor = false;
  double exponent = 0;  ///< beta of a unit "Pa^beta s"; 0 otherwise
  RandomDistribution distribution = RandomDistribution::normal;
  double mean = not_a_number;
  double standard_deviation = not_a_number;
  double lower = not_a_number;
  double upper = not_a_number;
  double mode = not_a_number;
  double shape = not_a_number;
  double scale = not_a_number;
  std::vector<double> values = {};   ///< of a discrete or an empirical distribution
  std::vector<double> weights = {};  ///< of the discrete values; empty: equal
};

/// Rank correlation of two random inputs.
struct RankCorrelation {
  std::array<std::string, 2> between = {};  ///< their first keys
  double rank = 0;                          ///< Spearman's
};

/// The draw that specializes the parameters to one sample with random inputs.
struct Draw {
  std::vector<double> values;         ///< of Study::random [SI]
  std::vector<std::string> settings;  ///< sample_settings() of the original input
};

/// A model, its samples and what differs between them, and what is recorded and measured of them.
struct Study : Model {
  Ensemble ensemble;
  Sections sections;
  Output output;
  std::vector<RandomInput> random = {};
  std::vector<RankCorrelation> correlations = {};
  std::optional<Draw> draw = {};  ///< in the study of one sample
};

}  // namespace crackle::input
