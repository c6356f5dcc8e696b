// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "experiment_keys.h"
#include "input/values.h"

#include <string>
#include <vector>

namespace crackle::experiment {

/// A place in the experiment's axes, in those of the body.
plane::Point in_body(const Draft& draft, const plane::Point& p);

/// Sets where the picture's pixels are in the body.
void place_picture(const Draft& draft, Picture& picture);

/// Completes the experiment by its files of path, tips and curve. Errors are reported at their keys.
/// @param prefix of the keys in messages: "experiment[0]."
void add_files(Draft& draft, const std::string& prefix, input::Context& context);

/// An experiment for each row of the file of loads.
std::vector<Experiment> experiments_of_loads(const Draft& draft, const std::string& prefix,
                                             input::Context& context);

}  // namespace crackle::experiment
