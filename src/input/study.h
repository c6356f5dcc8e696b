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
