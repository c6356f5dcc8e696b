// SPDX-License-Identifier: GPL-3.0-or-later
#include "dynamics/resolution.h"

#include "common/quantity_text.h"
#include "fracture/crack_vicinity.h"
#include "fracture/criterion.h"
#include "geometry/mother_points.h"
#include "input/softening_limits.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <utility>

namespace crackle::dynamics {

namespace {

/// Ratio of largest to smallest toughness above which the mesh, not the material, decides where cracks run
/// fast.
constexpr double uneven_toughness = 4.0 / 3;
/// Minimum spacings per radius of the averaging ball; below it results depend on the mesh.
constexpr double spacings_per_ball = 1.5;
/// Minimum spacings per correlation length; below it neighbouring tetrahedra differ strongly.
constexpr double spacings_per_correlation_length = 2;

/// Spacings over the height of a round end that resolve its stress.
constexpr double cells_per_round_end = 3;

double finest_spacing(const input::Mesh& mesh, const geometry::Body& body) {
  return geometry::SpacingField(body, mesh).lower_bound(body.bounds());
}

/// A warning if a uniform strength makes the toughness vary along the crack paths; otherwise empty.
std::string uneven_toughness_text(const input::Model& model, const geometry::Body& body, double time_step) {
  const input::Fracture law = model.fracture_of(0);
  if (law.toughness > 0 || law.length > 0) return {};
  const auto criterion =
      fracture::make_criterion(law, {law.strength}, time_step, mechanics::TetrahedronField(law.impulse));
  const auto range = toughness_along_ligaments(model, body, criterion->strength(0));
  if (!range || range->greatest <= uneven_toughness * range->least) return {};
  return fmt::format(
      "with one strength the toughness follows the spacing, {:.3g} to {:.3g} J/m^2 along the ligaments; make "
      "the spacing even there with [[mesh.region]], or give fracture.toughness instead of fracture.strength",
      range->least, range->greatest);
}

/// Rough strength of a material with this toughness without a crack [Pa]: of glasses, ceramics and polymers
/// flaws of some 0.2 mm decide, of hard steels a share of Young's modulus.
double usual_strength(const input::Material& material, double toughness) {
  constexpr double flaw = 2e-4;       // K_Ic^2 / strength^2 [m]
  constexpr double share = 1.0 / 80;  // of Young's modulus
  const double modulus = material.youngs_modulus, nu = material.poisson_ratio;
  return std::min(std::sqrt(toughness * modulus / ((1 - nu * nu) * flaw)), share * modulus);
}

/// A warning if waves, or loads on a body without a crack start, may break coarse tetrahedra of a material
/// that sustains more; otherwise empty.
std::string weak_mesh_text(const input::Model& model, const geometry::Body& body) {
  constexpr double low_share = 0.7;
  if (model.time.start != input::Start::rest && !body.crack_starts().empty()) return {};
  for (std::size_t m = 0; m < model.materials.size(); ++m) {
    const input::Fracture law = model.fracture_of(m);
    const input::Material& material = model.materials[m];
    if (law.toughness == 0 || law.strength > 0) continue;
    const double spacing =
        law.length > 0 ? fracture::spacings_per_length(law.release, material.poisson_ratio) * law.length
                       : model.mesh.spacing;
    const double factor = fracture::toughness_factor(law.release, material.poisson_ratio);
    const double held = std::sqrt(law.toughness * material.youngs_modulus / (factor * spacing));
    const double usual = usual_strength(material, law.toughness);
    if (held >= low_share * usual) continue;
    return fmt::format(
        "with a toughness alone tetrahedra of {} hold {}, whether at a crack or not, while such a material{} "
        "has a strength of some {}, if not more: cracks may start where none would; give fracture.strength, "
        "too",
        law.length > 0 ? "this averaging length" : quantity_text(spacing, "m"), quantity_text(held, "Pa"),
        material.name.empty() ? "" : fmt::format(" as \"{}\"", material.name), quantity_text(usual, "Pa"));
  }
  return {};
}

/// A warning if the mesh does not resolve the averaging ball; otherwise empty.
std::string unresolved_length_text(const input::Model& model, const geometry::Body& body) {
  const double length = model.fracture.length;
  if (length == 0) return {};
  const double greatest = crack_spacing(model.mesh, body).greatest;
  if (spacings_per_ball * greatest <= length) return {};
  return fmt::format(
      "the averaging length of {} is less than {:.2g} times the greatest spacing where cracks run, {}, so "
      "results depend on the mesh there; make it at most {} with [[mesh.region]]",
      quantity_text(length, "m"), spacings_per_ball, quantity_text(greatest, "m"),
      quantity_text(length / spacings_per_ball, "m"));
}

/// A warning if the mesh does not resolve the process zone of softening; otherwise empty.
std::string unresolved_softening_text(const input::Model& model, const geometry::Body& body) {
  if (!model.fracture.softens()) return {};
  const double greatest = crack_spacing(model.mesh, body).greatest;
  const double admissible = input::resolving_share * input::process_zone_length(model);
  if (greatest <= admissible) return {};
  const double snap_back = input::snap_back_spacing(model);
  return fmt::format(
      "where cracks run the spacing is up to {}, but softening requires {} or less{}; refine with "
      "[[mesh.region]]",
      quantity_text(greatest, "m"), quantity_text(admissible, "m"),
      greatest < snap_back
          ? std::string()
          : fmt::format(", and at {} or more tetrahedra break at once, with more energy than the toughness",
                        quantity_text(snap_back, "m")));
}

/// A warning if the mesh does not resolve the correlation of a random field, or the body is too small for it;
/// otherwise empty.
std::string unsuited_correlation_text(const std::string& of, double length, const std::string& uncorrelated,
                                      const input::Model& model, const geometry::Body& body) {
  if (length == 0) return uncorrelated;
  if (const double longest = std::ranges::max(body.size()); length > longest)
    return fmt::format(
        "the correlation length of the {}, {}, exceeds the body, {}: each sample is nearly uniform, and "
        "samples differ from each other instead",
        of, quantity_text(length, "m"), quantity_text(longest, "m"));
  const double finest = finest_spacing(model.mesh, body);
  if (length >= spacings_per_correlation_length * finest) return {};
  return fmt::format(
      "the correlation length of the {}, {}, is less than {:.0f} spacings of {}, so results depend on the "
      "spacing; give a longer one, or a finer mesh",
      of, quantity_text(length, "m"), spacings_per_correlation_length, quantity_text(finest, "m"));
}

std::string unresolved_strength_text(const input::Model& model, const geometry::Body& body) {
  const auto& variation = model.fracture.variation;
  if (!variation) return {};
  const std::string what = variation->of == input::Varies::toughness ? "toughness" : "strength";
  return unsuited_correlation_text(
      what, variation->correlation_length,
      fmt::format("each tetrahedron has a {} of its own, so only the load at the first break of a smoothly "
                  "stressed body does not depend on the spacing; give fracture.variation.correlation_length, "
                  "of several spacings, for cracks",
                  what),
      model, body);
}

std::string unresolved_stiffness_text(const input::Model& model, const input::StiffnessVariation& variation,
                                      const geometry::Body& body) {
  const std::string what = variation.of == input::StiffnessVaries::density ? "density" : "stiffness";
  return unsuited_correlation_text(
      what, variation.correlation_length,
      fmt::format("each tetrahedron has a {} of its own, so results depend on the spacing; give "
                  "material.variation.correlation_length, of several spacings",
                  what),
      model, body);
}

/// A warning for each square end that is too high for a crack: it has two corners, whose load follows the
/// spacing.
std::vector<std::string> high_end_texts(const input::Model& model, const geometry::Body& body) {
  if (model.fracture.length > 0 || model.fracture.softens()) return {};
  const geometry::SpacingField spacing(body, model.mesh);
  std::vector<std::string> texts;
  for (const fracture::SquareEnd& end : fracture::square_ends(model.specimen)) {
    const double height = 2 * end.half_height;
    const auto point = [&](double advance) {
      return geometry::Point{body.size()[0] / 2, end.place[0] + advance * end.ahead[0],
                             end.place[1] + advance * end.ahead[1]};
    };
    if (!fracture::is_high(end, spacing, body.size()[0]) || !body.contains(point(0.01 * height))) continue;
    texts.push_back(fmt::format(
        "the square end of specimen.notch[{}] is {} high, more than {} spacings of {}: it is no crack, and "
        "its "
        "load follows the spacing; give from and to with end = \"round\", a notch_spacing of at most {} and "
        "fracture.strength; or, for a crack, a notch_spacing of at least {}",
        end.notch, quantity_text(height, "m"), fracture::highest_end_in_spacings,
        quantity_text(spacing(point(0)), "m"), quantity_text(height / cells_per_round_end, "m"),
        quantity_text(height / fracture::highest_end_in_spacings, "m")));
  }
  return texts;
}

}  // namespace

fracture::Range crack_spacing(const input::Mesh& mesh, const geometry::Body& body) {
  return fracture::spacing_along_ligaments(mesh, body)
      .value_or(fracture::Range{finest_spacing(mesh, body), mesh.spacing});
}

std::optional<fracture::Range> toughness_along_ligaments(const input::Model& model,
                                                         const geometry::Body& body, double strength) {
  const auto spacing = fracture::spacing_along_ligaments(model.mesh, body);
  if (!spacing) return std::nullopt;
  return fracture::Range{fracture::toughness_of(model, strength, spacing->least),
                         fracture::toughness_of(model, strength, spacing->greatest)};
}

std::vector<std::string> resolution_warnings(const input::Model& model, const geometry::Body& body,
                                             double time_step) {
  std::vector<std::string> warnings;
  // The spacings of points from a file are not known.
  if (!model.mesh.points) {
    warnings = {uneven_toughness_text(model, body, time_step), unresolved_length_text(model, body),
                unresolved_softening_text(model, body), weak_mesh_text(model, body)};
    for (auto& text : high_end_texts(model, body)) warnings.push_back(std::move(text));
  }
  warnings.push_back(unresolved_strength_text(model, body));
  for (const input::Material& material : model.materials)
    if (material.variation) warnings.push_back(unresolved_stiffness_text(model, *material.variation, body));
  std::erase(warnings, std::string());
  return warnings;
}

}  // namespace crackle::dynamics
