// SPDX-License-Identifier: GPL-3.0-or-later
#include "crackle/ensemble/base_points.h"

#include "crackle/ensemble/progress.h"
#include "crackle/ensemble/results.h"
#include "crackle/io/ensemble_file.h"

#include <fmt/format.h>

#include <stdexcept>

namespace crackle::ensemble {

namespace {

constexpr double seconds_per_mother_point = 45e-6;  // on one core; much the same at 5e4 and at 8e5 points
constexpr double short_wait = 5;                    // [s]

}  // namespace

std::string waiting_notice(double n_mother_points) {
  const double seconds = seconds_per_mother_point * n_mother_points;
  if (seconds < short_wait) return {};
  return fmt::format("placing some {:.2g} million mother points takes about {}", n_mother_points / 1e6,
                     format_duration(seconds));
}

geometry::MotherPoints make_base_points(const geometry::Body& body, const input::Parameters& parameters,
                                        const std::function<void(const std::string&)>& say) {
  return geometry::make_mother_points(body, parameters.mesh, parameters.ensemble.seed, [&](double n_points) {
    const std::string notice = waiting_notice(n_points);
    if (say && !notice.empty()) say(notice);
  });
}

geometry::MotherPoints base_points(const std::filesystem::path& folder, const input::Parameters& parameters) {
  try {
    return io::read_mother_points(results_file(folder), parameters);
  } catch (const std::runtime_error&) {
    return make_base_points(geometry::Body(parameters.specimen), parameters);
  }
}

}  // namespace crackle::ensemble
