// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "crackle/plane/shape.h"

#include <filesystem>
#include <optional>
#include <string>
#include <vector>

/// Experiments, and how an ensemble is compared with them.
namespace crackle::experiment {

/// Points of a crack or another line, in order [m].
using Polyline = std::vector<plane::Point>;

/// The crack's tip at one moment.
struct Tip {
  double time = 0;    ///< since the crack began to run [s]
  plane::Point at{};  ///< y and z in the body [m]
};

/// A picture of the crack or of fringes. Its horizontal axis is y of the experiment's own axes, its vertical
/// axis, upwards, their z.
struct Picture {
  std::filesystem::path file;
  double time = 0;            ///< since the crack began to run [s]
  double scale = 0;           ///< [m per pixel]
  plane::Point origin{};      ///< of the experiment's axes: pixels from the left and from the top
  /// Place of the upper left corner in the body, and the steps from pixel to pixel there [m].
  plane::Point corner{}, right{}, down{};
  bool has_dark_field = true;
  bool is_reversed = false;  ///< colours
};

/// A measured load over displacement.
struct LoadCurve {
  std::vector<double> displacement;  ///< [m]
  std::vector<double> load;          ///< [N]
};

/// One experiment; all parts are optional. Places are in the body's axes.
struct Experiment {
  std::string name = {};
  std::vector<Polyline> lines = {};  ///< of the crack; the first one is its main arm
  double path_error = 0;             ///< standard deviation of the points as read [m]
  double path_error_length = 0;      ///< correlation length of that error along the path [m]
  bool is_arrested = false;          ///< the crack ends where its path ends
  std::optional<double> onset_load = {}, peak_load = {};  ///< [N]
  double load_error = 0;                                  ///< standard deviation [N]
  std::vector<Tip> tips = {};
  double time_error = 0;  ///< standard deviation [s]
  std::vector<Picture> pictures = {};
  LoadCurve curve = {};
};

/// Reads experiments from a TOML file and the files that it names, relative to its folder. An experiment with
/// `loads` becomes one experiment for each row of that file.
/// @throws input::InputError with every error
std::vector<Experiment> read_experiments(const std::filesystem::path& file);

/// Every key of an experiments file as "table.key", with the table empty for the keys at the top.
std::vector<std::string> experiment_keys();

/// The keys of an experiment, without those of its tips and pictures, as comments: "#key = example" after
/// "# meaning: accepted values".
/// @param skipped names of keys that are left out
std::string explained_experiment_keys(const std::vector<std::string>& skipped);

}  // namespace crackle::experiment
