// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "crackle/analysis/sample_results.h"
#include "crackle/geometry/body.h"
#include "crackle/input/parameters.h"
#include "hdf5.h"

#include <string>

namespace crackle::io {

/// What a reader has to know of a result's dataset, as its attributes: meaning, label, shown_units,
/// shown_factor, format, and categories where its numbers stand for words. `units` are there already.
void describe_result(hid_t parent, const std::string& dataset, const analysis::ResultInfo& info, int column);

/// The attribute `meaning` of a dataset that is no result.
void describe_dataset(hid_t parent, const std::string& dataset, const std::string& meaning);

/// Keys of the random inputs, in their order, as names of datasets.
std::vector<std::string> random_keys(const input::Parameters& parameters);
/// The attribute `keys` of the group that has these datasets: one in each line.
void write_random_keys(hid_t group, const input::Parameters& parameters);
/// SI unit of a random input's values; "1" for plain numbers.
std::string units_of(const input::RandomInput& random);

/// Writes the group /specimen: the members of geometry::for_each_member, for those who draw the body.
void write_specimen(hid_t file, const geometry::Body& body);

/// The dataset `status`: 0 pending, 1 done, 2 failed.
extern const analysis::ResultInfo status_info;
/// The dataset `wall_time`.
extern const analysis::ResultInfo wall_time_info;

}  // namespace crackle::io
