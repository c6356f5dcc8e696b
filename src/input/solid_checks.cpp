// SPDX-License-Identifier: GPL-3.0-or-later
// What can be wrong with a solid from a file, and with conditions on it.
#include "solid_checks.h"
#include "condition_faces.h"
#include "consistency.h"
#include "dimension.h"
#include "document.h"
#include "figures.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <string>

namespace crackle::input {

// Beside those of the plane.
using crackle::operator+;
using crackle::operator-;
using crackle::operator*;

namespace {

/// Limits of regions are met to this share of the body's size.
constexpr double slack_share = 1e-9;
/// Edges of the body are at least this share of the spacing there.
constexpr double finest_detail = 1.0 / 50;

std::string show_place(const Vector& p) {
  return fmt::format("({}, {}, {})", shown_length(p[0]), shown_length(p[1]), shown_length(p[2]));
}

/// The part of two regions that both contain; slightly more, so that a line has an area.
plane::Region common_part(const solid::Solid& body, const plane::Region& a, const plane::Region& b) {
  double size = 0;
  for (const auto& [lower, upper] : body.bounds) size = std::max(size, upper - lower);
  plane::Region part;
  for (std::size_t i = 0; i < 3; ++i)
    part[i] = {std::max(a[i].first, b[i].first) - slack_share * size,
               std::min(a[i].second, b[i].second) + slack_share * size};
  return part;
}

double area_of(const solid::Solid& body, const Boundary& condition) {
  return area_in(body, condition.on, condition.on, common_part(body, condition.region, plane::everywhere));
}

/// The spacing that the input gives at a point.
double spacing_at(const Mesh& mesh, const Vector& p) {
  double spacing = mesh.spacing;
  for (const MeshRegion& region : mesh.regions) {
    Vector gap{};
    for (std::size_t i = 0; i < 3; ++i)
      gap[i] = std::max({0.0, region.box[i].first - p[i], p[i] - region.box[i].second});
    spacing = std::min(spacing, region.spacing + mesh.growth * norm(gap));
  }
  return spacing;
}

}  // namespace

void complete_solid(Parameters& parameters, Findings& findings) {
  plane::Specimen& specimen = parameters.specimen;
  const bool is_given = findings.given("specimen.solid");
  if (is_given != findings.given("specimen.unit")) {
    if (is_given)
      findings.report("specimen.unit",
                      "the key is missing, but solid requires it; give a unit such as \"mm\"");
    else
      findings.report("specimen.unit", "requires solid; leave it out");
  }
  if (!is_given) return;
  for (const char* const key : {"size", "thickness", "outline", "radius"})
    if (findings.given(fmt::format("specimen.{}", key)))
      findings.report(fmt::format("specimen.{}", key), "cannot be combined with solid; leave it out");
  for (const char* const table : {"notch", "hole", "region"})
    if (findings.given(fmt::format("specimen.{}", table)))
      findings.report(fmt::format("specimen.{}", table),
                      "requires a plate; leave it out, or make it part of the solid's file");
  if (specimen.solid)
    for (std::size_t i = 0; i < 3; ++i)
      specimen.size[i] = specimen.solid->bounds[i].second - specimen.solid->bounds[i].first;
}

void check_solid(const Parameters& parameters, Findings& findings) {
  if (findings.faulty("specimen") || !has_spacing(parameters, findings)) return;
  const solid::Solid& body = *parameters.specimen.solid;
  const solid::Sharpness sharp = solid::sharpest(body);
  check_corner({sharp.angle, {}},
               fmt::format("{} at {}", sharp.is_edge ? "the edge of the body" : "the corner of a face",
                           show_place(sharp.place)),
               parameters, findings);
  for (const auto& [from, to] : body.edges) {
    const Vector &a = body.points[index(from)], &b = body.points[index(to)];
    const double wanted = spacing_at(parameters.mesh, 0.5 * (a + b));
    if (norm(b - a) >= finest_detail * wanted) continue;
    findings.report("specimen.solid",
                    "has an edge of {} at {}, less than a fiftieth of the spacing there, {}; remove such "
                    "details, or give a finer spacing",
                    show(norm(b - a)), show_place(a), show(wanted));
    return;
  }
}

void check_region_of_solid(const Boundary& condition, const std::string& key, const solid::Solid& body,
                           Findings& findings) {
  const auto faces = solid::named_faces(body);
  if (std::ranges::find(faces, condition.on, &solid::NamedFace::name) == faces.end()) {
    std::string names;
    for (std::size_t i = 0; i < std::min<std::size_t>(faces.size(), 20); ++i)
      names += fmt::format("{}\"{}\"", i > 0 ? ", " : "", faces[i].name);
    findings.report(key + ".on", "\"{}\" is not known; give one of {}{}", shortened(condition.on), names,
                    faces.size() > 20 ? " and so on, which crackle check lists" : "");
    return;
  }
  if (area_of(body, condition) > 0) return;
  plane::Region bounds{std::pair{infinity, -infinity}, {infinity, -infinity}, {infinity, -infinity}};
  for (std::size_t f = 0; f < body.facets.size(); ++f) {
    const auto& names = body.faces[index(body.face_of[f])].names;
    if (std::ranges::find(names, condition.on) == names.end()) continue;
    for (const auto corner : body.facets[f])
      for (std::size_t i = 0; i < 3; ++i)
        bounds[i] = {std::min(bounds[i].first, body.points[index(corner)][i]),
                     std::max(bounds[i].second, body.points[index(corner)][i])};
  }
  std::string ranges;
  for (std::size_t i = 0; i < 3; ++i)
    ranges += fmt::format("{}{} from {} to {}",
                          i == 0   ? ""
                          : i == 1 ? ", "
                                   : " and ",
                          axis_names[i], shown_length(bounds[i].first), shown_length(bounds[i].second));
  findings.report(key + ".region", "misses \"{}\", which has {}", condition.on, ranges);
}

double share_driven(const Boundary& load, const Boundary& motion, const solid::Solid& body) {
  const double all = area_of(body, load);
  return all > 0 ? area_in(body, load.on, motion.on, common_part(body, load.region, motion.region)) / all : 0;
}

bool have_common_part(const Boundary& a, const Boundary& b, const solid::Solid& body) {
  // Regions may share a border, which the slack makes a strip.
  return share_driven(a, b, body) > 1e-3 || share_driven(b, a, body) > 1e-3;
}

}  // namespace crackle::input
