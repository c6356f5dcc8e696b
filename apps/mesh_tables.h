// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "crackle/common/text_table.h"
#include "crackle/geometry/mother_points.h"
#include "crackle/geometry/realization.h"
#include "crackle/geometry/survey.h"
#include "crackle/input/parameters.h"
#include "crackle/input/reader.h"

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <span>
#include <string>
#include <vector>

/// Output of `crackle mesh`.
namespace crackle::apps {

struct MeshTimes {
  double base;         ///< of the mother points [s]
  double realization;  ///< [s]
};

/// The figures of one realization.
/// @param n_ranks ranks for the partition; 1: no partition
std::vector<NamedValue> mesh_table(const input::Parameters& parameters, std::uint64_t sample,
                                   const geometry::MotherPoints& base,
                                   const geometry::Realization& realization, const MeshTimes& times,
                                   int n_ranks);

/// The tetrahedra of each material; nothing if the body has only one.
std::vector<NamedValue> material_rows(const input::Parameters& parameters,
                                      const geometry::Realization& realization);

/// The variation of strength between tetrahedra, as a line of the table.
NamedValue variation_row(const std::vector<double>& strength_factors);

/// Results of a survey.
struct SurveyFigures {
  std::size_t n_nodes;  ///< of every realization; with mesh.base = "own" of sample 0
  double base_seconds;  ///< time to place the mother points [s]
  geometry::OrientationMoments base_orientation;
  std::vector<geometry::SurveyRow> rows;  ///< including failed ones
  double stable_step;                     ///< of the first realization [s]
};

/// Common properties and variation of the realizations.
std::string survey_table(const input::Parameters& parameters, const SurveyFigures& figures);

/// One line for each realization, comma-separated, with a heading.
std::string survey_csv(std::span<const geometry::SurveyRow> rows);

/// Makes realizations 0 to n_samples - 1, shows the progress on standard error and prints survey_table().
/// Writes survey_csv() to `table`, unless that is empty.
/// @return true if all realizations conform
/// @throws std::runtime_error when there are no base points or the table cannot be written
bool survey_meshes(const input::Parameters& parameters, std::uint64_t n_samples,
                   const std::filesystem::path& table);

}  // namespace crackle::apps
