// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "analysis/result_list.h"
#include "geometry/body.h"
#include "hdf5.h"
#include "input/study.h"

#include <span>
#include <string>

namespace crackle::io {

/// Writes the metadata of a result's dataset as attributes: meaning, label, shown_units, shown_factor,
/// format, and categories if its numbers encode words. `units` must be present already.
void describe_result(hid_t parent, const std::string& dataset, const analysis::ResultInfo& info, int column);

/// Writes the attribute `meaning` of a dataset that is not a result.
void describe_dataset(hid_t parent, const std::string& dataset, const std::string& meaning);

/// Describes the dataset crack_area_in of a group: metadata, the names of the parts, its last dimension.
void describe_parts(hid_t group, const std::vector<std::string>& parts, int column);

/// Keys of the random inputs, in their order, as dataset names.
std::vector<std::string> random_keys(const std::vector<input::RandomInput>& random);
/// Writes the attribute `keys` of the group with these datasets, one per line.
void write_random_keys(hid_t group, const std::vector<input::RandomInput>& random);
/// SI unit of a random input's values; "1" for dimensionless numbers.
std::string units_of(const input::RandomInput& random);

/// @param name of the row, before the message
/// @throws hdf5::Error if the row has a number that no computation gives: an infinite one, or a random input
///   that is none
void check_numbers(const analysis::SampleSummary& row, const std::vector<std::string>& random_keys,
                   const std::string& name = {});

/// Writes the group /specimen: the members of geometry::for_each_member, for drawing the body.
void write_specimen(hid_t file, const geometry::Body& body, std::span<const plane::PreCrack> flaws = {});

/// The dataset `status`: 0 pending, 1 done, 2 failed.
extern const analysis::ResultInfo status_info;
/// The dataset `wall_time`.
extern const analysis::ResultInfo wall_time_info;

}  // namespace crackle::io
