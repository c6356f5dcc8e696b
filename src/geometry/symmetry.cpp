// SPDX-License-Identifier: GPL-3.0-or-later
#include "geometry/symmetry.h"

#include "common/failure.h"
#include "common/index.h"
#include "common/vector.h"
#include "geometry/mesh_regions.h"
#include "input/boundary_kind.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <functional>
#include <optional>
#include <set>
#include <stdexcept>
#include <utility>

namespace crackle::geometry {

namespace {

constexpr double tolerance = 1e-12;  ///< of coordinates, relative to the body's largest size

}  // namespace

std::vector<Symmetry> symmetries(const Body& body, const input::Mesh& mesh) {
  const Point size = body.size();
  const double near = tolerance * *std::ranges::max_element(size);
  // Symmetries are isometries, so a box whose corners map onto corners of another box maps onto that box.
  const auto maps = [&](const Symmetry& symmetry, const input::MeshRegion& from,
                        const input::MeshRegion& to) {
    const auto corners = corners_of(box_of(to, body.bounds()));
    return from.spacing == to.spacing &&
           std::ranges::all_of(corners_of(box_of(from, body.bounds())), [&](const Point& p) {
             const Point image = symmetry.image(p);
             return std::ranges::any_of(corners, [&](const Point& corner) {
               const Point gap = image - corner;
               return std::ranges::all_of(gap, [&](double each) { return std::abs(each) <= near; });
             });
           });
  };
  std::vector<Symmetry> result = body.symmetries();
  std::erase_if(result, [&](const Symmetry& symmetry) {
    return !std::ranges::all_of(mesh.regions, [&](const input::MeshRegion& from) {
      return std::ranges::any_of(mesh.regions, [&](const auto& to) { return maps(symmetry, from, to); });
    });
  });
  return result;
}

Symmetry symmetry_of(const Body& body, std::uint8_t code) {
  for (Symmetry& symmetry : body.symmetries())
    if (symmetry.code == code) return std::move(symmetry);
  fail<std::invalid_argument>("the body has no symmetry {}", code);
}

namespace {

constexpr double load_tolerance = 1e-9;  ///< of places and amounts, relative to the largest

using History = input::FactorTable;

/// The value and the rate of a force, a displacement and a velocity.
struct Amount {
  std::array<double, 6> values{};

  friend Amount operator+(Amount a, const Amount& b) {
    for (std::size_t i = 0; i < a.values.size(); ++i) a.values[i] += b.values[i];
    return a;
  }
  friend Amount operator*(double factor, Amount a) {
    for (double& each : a.values) each *= factor;
    return a;
  }
  double largest() const {
    return std::abs(*std::ranges::max_element(values, {}, [](double each) { return std::abs(each); }));
  }
};

enum class EffectKind { force, motion, absorbing };

/// A condition's effect on one component at one face, or at the part of a face in its region.
struct Effect {
  EffectKind kind;
  std::size_t component;
  std::size_t condition;  ///< number
  double share;           ///< of the condition's area in this place
  Box place;
  Amount amount;  ///< of a force: the part of this place; without the factor
  const History* history;
  const std::optional<input::Profile>* factor;
};

/// The part of a face in a region; empty if they do not meet.
Box part_of(const Face& face, const plane::Region& region) {
  Box part = face.patch.bounds();
  for (std::size_t i = 0; i < 3; ++i) {
    part.lower[i] = std::max(part.lower[i], region[i].first);
    part.upper[i] = std::min(part.upper[i], region[i].second);
  }
  return part;
}

bool is_empty(const Box& box) {
  return box.lower[0] > box.upper[0] || box.lower[1] > box.upper[1] || box.lower[2] > box.upper[2];
}

/// The area of the part of a face.
double area_of(const Face& face, const Box& part) {
  const Box whole = face.patch.bounds();
  double area = face.area;
  for (std::size_t i = 0; i < 3; ++i)
    if (whole.upper[i] > whole.lower[i])
      area *= (part.upper[i] - part.lower[i]) / (whole.upper[i] - whole.lower[i]);
  return area;
}

Amount amount_of(const input::Boundary& condition, const Face& face, std::size_t component, double area,
                 double share) {
  const double value = condition.value[component], rate = condition.rate[component];
  switch (condition.kind) {
    case input::BoundaryKind::force:
      return {share * value, share * rate};
    case input::BoundaryKind::traction:
      return {area * value, area * rate};
    case input::BoundaryKind::pressure: {
      const double outward = face.outward[component];
      const double against = std::abs(outward) > load_tolerance ? -outward * area : 0;
      return {against * condition.value[0], against * condition.rate[0]};
    }
    case input::BoundaryKind::displacement:
      return {0, 0, value, rate};
    case input::BoundaryKind::velocity:
      return {0, 0, 0, 0, value, rate};
    case input::BoundaryKind::fix:
    case input::BoundaryKind::absorbing:
      break;
  }
  return {};
}

std::vector<Effect> effects_of(const Body& body, const std::vector<input::Boundary>& conditions) {
  std::vector<Effect> effects;
  for (std::size_t number = 0; number < conditions.size(); ++number) {
    const input::Boundary& condition = conditions[number];
    std::vector<std::pair<const Face*, Box>> parts;
    double whole_area = 0;
    for (const FaceId id : body.faces_named(condition.on)) {
      const Face& face = body.faces()[index(id)];
      if (const Box part = part_of(face, condition.region); !is_empty(part)) {
        parts.emplace_back(&face, part);
        whole_area += area_of(face, part);
      }
    }
    const input::Action action = input::traits(condition.kind).action;
    const EffectKind kind = action == input::Action::load     ? EffectKind::force
                            : action == input::Action::motion ? EffectKind::motion
                                                              : EffectKind::absorbing;
    for (const auto& [face, place] : parts) {
      const double area = area_of(*face, place);
      const double share = whole_area > 0 ? area / whole_area : 1 / static_cast<double>(parts.size());
      if (share == 0) continue;
      for (std::size_t k = 0; k < 3; ++k) {
        const Amount amount = amount_of(condition, *face, k, area, share);
        if (kind == EffectKind::force ? amount.largest() > 0
                                      : kind == EffectKind::absorbing || condition.components[k])
          effects.push_back({kind, k, number, share, place, amount, &condition.history, &condition.factor});
      }
    }
  }
  return effects;
}

/// All effects on one component.
struct Component {
  bool is_driven = false;               ///< something is not zero
  bool has_one_history = true;          ///< of all that is not zero
  std::set<std::size_t> supports = {};  ///< the conditions that prescribe its motion
  Amount load = {};                     ///< sum of the forces
};

Component component_of(const std::vector<Effect>& effects, std::size_t k) {
  Component found;
  const History* history = nullptr;
  for (const Effect& effect : effects) {
    if (effect.component != k) continue;
    if (effect.kind == EffectKind::motion) found.supports.insert(effect.condition);
    if (effect.kind == EffectKind::force) found.load = found.load + effect.amount;
    if (effect.amount.largest() == 0) continue;
    found.is_driven = true;
    found.has_one_history = found.has_one_history && (history == nullptr || *history == *effect.history);
    history = effect.history;
  }
  return found;
}

/// A vector at every point of the body, affine in the coordinates.
using Field = std::function<Vector(const Point&)>;

/// The body forces, their rates, and the initial velocity.
std::vector<Field> fields_of(const input::Model& model) {
  std::vector<Field> fields;
  for (const input::BodyLoad& load : model.body_forces()) {
    fields.push_back([load](const Point& p) { return load.at(p); });
    fields.push_back([load](const Point&) { return load.rate; });
  }
  fields.push_back([velocities = model.initial_velocities()](const Point& p) {
    Vector sum{};
    for (const input::BodyLoad& velocity : velocities) sum = sum + velocity.at(p);
    return sum;
  });
  return fields;
}

/// True if the stress from the start, and a raster of the material, are the same after a reflection.
/// @param reverses whether it reverses each axis
bool keeps_the_state(const input::Model& model, const Box& bounds, const std::array<bool, 3>& reverses) {
  if (model.map)
    for (const int axis : model.map->axes)
      if (reverses[index(axis)]) return false;
  constexpr int n_points = 64;
  return std::ranges::all_of(model.initial_stresses, [&](const input::InitialStress& initial) {
    const std::size_t axis = index(initial.along);
    if (!reverses[axis]) return true;
    const std::pair extent{bounds.lower[axis], bounds.upper[axis]};
    double largest = 0, difference = 0;
    for (int i = 0; i <= n_points; ++i) {
      const double offset = (extent.second - extent.first) * i / n_points;
      const double here = input::value_at(initial, extent, extent.first + offset);
      const double there = input::value_at(initial, extent, extent.second - offset);
      largest = std::max(largest, std::abs(here));
      difference = std::max(difference, std::abs(here - there));
    }
    return difference <= load_tolerance * largest;
  });
}

/// A corner and its neighbours, which determine an affine field.
std::array<Point, 4> spanning_points(const Box& box) {
  std::array<Point, 4> corners;
  corners.fill(box.lower);
  for (std::size_t k = 0; k < 3; ++k) corners[k + 1][k] = box.upper[k];
  return corners;
}

/// The effects of a body's conditions, to be compared with their images.
class Loads {
public:
  Loads(const Body& body, const input::Model& model)
      : model_(&model),
        bounds_(body.bounds()),
        near_(load_tolerance * std::ranges::max(body.size())),
        effects_(effects_of(body, model.boundaries)),
        fields_(fields_of(model)),
        is_in_equilibrium_(model.time.start != input::Start::rest) {
    for (std::size_t k = 0; k < 3; ++k) all_[k] = component_of(effects_, k);
    // Where loads are not simple sums, a support counts as the image of another support only.
    const bool are_simple =
        model.body_forces().empty() &&
        std::ranges::none_of(effects_, [](const Effect& effect) { return effect.factor->has_value(); });
    if (are_simple)
      has_central_support_ = has_central_support();
    else
      for (Component& all : all_) all.has_one_history = false;
    for (const Field& field : fields_)
      for (const Point& corner : spanning_points(bounds_))
        for (std::size_t k = 0; k < 3; ++k) all_[k].is_driven = all_[k].is_driven || field(corner)[k] != 0;
  }

  bool are_symmetric(const Symmetry& symmetry) const {
    // Opposite corners tell which components are reversed.
    const Point lower = symmetry.image(bounds_.lower), upper = symmetry.image(bounds_.upper);
    std::array<std::optional<Amount>, 3> translation;
    const auto sign = [&](std::size_t k) { return lower[k] > upper[k] ? -1.0 : 1.0; };
    if (!keeps_the_state(*model_, bounds_, {sign(0) < 0, sign(1) < 0, sign(2) < 0})) return false;
    for (const Field& field : fields_)
      if (!is_symmetric(field, symmetry, {sign(0), sign(1), sign(2)})) return false;
    return std::ranges::all_of(effects_, [&](const Effect& effect) {
      const std::size_t k = effect.component;
      Box image = nowhere;
      image.include(symmetry.image(effect.place.lower));
      image.include(symmetry.image(effect.place.upper));
      return is_found(effect, image, symmetry, sign(k), translation[k]);
    });
  }

private:
  bool is_symmetric(const Field& field, const Symmetry& symmetry, const Vector& signs) const {
    double largest = 0, difference = 0;
    for (const Point& corner : spanning_points(bounds_)) {
      const Vector here = field(corner), there = field(symmetry.image(corner));
      for (std::size_t k = 0; k < 3; ++k) {
        largest = std::max({largest, std::abs(here[k]), std::abs(there[k])});
        difference = std::max(difference, std::abs(signs[k] * here[k] - there[k]));
      }
    }
    return difference <= load_tolerance * largest;
  }

  /// True if a single support carries all loads, and these have no moment about its middle.
  bool has_central_support() const {
    std::set<std::size_t> supports;
    for (const Component& all : all_)
      if (all.is_driven) supports.insert(all.supports.begin(), all.supports.end());
    if (supports.size() != 1) return false;
    Box box = nowhere;
    for (const Effect& effect : effects_) {
      if (effect.condition != *supports.begin()) continue;
      box.include(effect.place.lower);
      box.include(effect.place.upper);
    }
    Vector moment{}, moment_rate{};
    double most = 0;
    for (const Effect& effect : effects_) {
      if (effect.kind != EffectKind::force) continue;
      const Vector arm = 0.5 * (effect.place.lower + effect.place.upper) + -0.5 * (box.lower + box.upper);
      Vector direction{};
      direction[effect.component] = 1;
      moment = moment + effect.amount.values[0] * cross(arm, direction);
      moment_rate = moment_rate + effect.amount.values[1] * cross(arm, direction);
      most = std::max(most, effect.amount.largest());
    }
    return std::max(norm(moment), norm(moment_rate)) <= near_ * most;
  }

  bool are_near(const Box& a, const Box& b) const {
    for (std::size_t i = 0; i < 3; ++i)
      if (std::abs(a.lower[i] - b.lower[i]) > near_ || std::abs(a.upper[i] - b.upper[i]) > near_)
        return false;
    return true;
  }

  bool is_driven(const Box& place) const {
    return std::ranges::any_of(effects_, [&](const Effect& effect) {
      return all_[effect.component].is_driven && are_near(effect.place, place);
    });
  }

  /// True if something in the image of an effect's place acts as its image.
  /// @param translation of the component's prescribed motions, once known
  bool is_found(const Effect& effect, const Box& image, const Symmetry& symmetry, double sign,
                std::optional<Amount>& translation) const {
    if (std::ranges::any_of(effects_, [&](const Effect& other) {
          return other.component == effect.component && are_near(other.place, image) &&
                 is_image(other, effect, symmetry, sign, translation);
        }))
      return true;
    return is_in_equilibrium_ && effect.kind == EffectKind::motion && !all_[effect.component].is_driven &&
           is_driven(effect.place) && is_driven(image);
  }

  /// True if two amounts, times their factors, are images of each other everywhere.
  bool are_images(const Effect& other, const Effect& effect, const Symmetry& symmetry, double sign) const {
    const auto value = [](const Effect& one, double at) { return *one.factor ? (*one.factor)->at(at) : 1.0; };
    const std::size_t axis = *effect.factor ? (*effect.factor)->axis : (*other.factor)->axis;
    if (*other.factor && (*other.factor)->axis != axis) return false;
    const auto at = [&](double coordinate) {
      Point p = effect.place.lower;
      p[axis] = coordinate;
      return p;
    };
    // Both are linear between the kinks of either.
    std::set<double> coordinates{effect.place.lower[axis], effect.place.upper[axis]};
    const auto add = [&](double kink) {
      coordinates.insert(std::clamp(kink, effect.place.lower[axis], effect.place.upper[axis]));
    };
    if (*effect.factor)
      for (const auto& [kink, factor] : (*effect.factor)->table) add(kink);
    if (*other.factor)
      for (const auto& [kink, factor] : (*other.factor)->table) add(symmetry.preimage(at(kink))[axis]);
    double largest = 0, difference = 0;
    for (const double coordinate : coordinates) {
      const Amount here = (sign * value(effect, coordinate)) * effect.amount;
      const Amount there = value(other, symmetry.image(at(coordinate))[axis]) * other.amount;
      largest = std::max({largest, here.largest(), there.largest()});
      difference = std::max(difference, (there + -1 * here).largest());
    }
    return difference <= load_tolerance * largest;
  }

  bool is_image(const Effect& other, const Effect& effect, const Symmetry& symmetry, double sign,
                std::optional<Amount>& translation) const {
    const Component& all = all_[effect.component];
    const auto are_close = [](const Amount& a, const Amount& b) {
      return (a + -1 * b).largest() <= load_tolerance * std::max(a.largest(), b.largest());
    };
    const Amount expected = sign * effect.amount;
    if (effect.kind != other.kind) {
      if (!is_in_equilibrium_ || !all.has_one_history || !has_central_support_) return false;
      if (effect.kind == EffectKind::motion) return are_close(other.amount, -sign * effect.share * all.load);
      return other.kind == EffectKind::motion && are_close(expected, -1 * (other.share * all.load));
    }
    if (effect.kind == EffectKind::motion && is_in_equilibrium_ && all.has_one_history) {
      if (!translation) translation = other.amount + -1 * expected;
      return are_close(other.amount, expected + *translation);
    }
    const bool is_uniform = !*effect.factor && !*other.factor;
    return (is_uniform ? are_close(other.amount, expected) : are_images(other, effect, symmetry, sign)) &&
           (*effect.history == *other.history || effect.amount.largest() == 0);
  }

  const input::Model* model_;
  Box bounds_;
  double near_;  ///< [m]
  std::vector<Effect> effects_;
  std::vector<Field> fields_;
  bool is_in_equilibrium_;
  std::array<Component, 3> all_{};
  bool has_central_support_ = false;
};

}  // namespace

std::vector<Symmetry> loaded_symmetries(const Body& body, const input::Model& model) {
  const Loads loads(body, model);
  std::vector<Symmetry> result = body.symmetries();
  if (!model.tools.empty())
    std::erase_if(result, [](const Symmetry& symmetry) { return symmetry.code != 0; });
  std::erase_if(
      result, [&](const Symmetry& symmetry) { return symmetry.code != 0 && !loads.are_symmetric(symmetry); });
  return result;
}

}  // namespace crackle::geometry
