// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "crackle/experiment/experiments_file.h"
#include "input/table.h"

#include <string>

/// The keys of an experiments file.
namespace crackle::experiment {

enum class Mirror { none, y, z };

/// An experiment as its table says it, before the files are read that it names.
struct Draft {
  Experiment experiment;
  plane::Point origin{};  ///< of the experiment's axes in the body [m]
  double angle = 0;       ///< of the experiment's y axis, from y towards z of the body [rad]
  Mirror mirror = Mirror::none;
  std::string path, tips, curve, loads;  ///< files
  double load_per_strength = 0;          ///< [m^2]
};

/// `loads` and what goes with it, before the first table.
const input::BasicTable<Draft>& top_table();
const input::BasicTable<Draft>& experiment_table();
const input::BasicTable<Tip>& tip_table();
const input::BasicTable<Picture>& picture_table();

}  // namespace crackle::experiment
