// SPDX-License-Identifier: GPL-3.0-or-later
#include "crackle/mechanics/boundary_loads.h"

#include "crackle/common/index.h"
#include "crackle/common/real.h"
#include "crackle/geometry/body.h"
#include "crackle/geometry/condition_region.h"
#include "crackle/mechanics/elasticity.h"
#include "crackle/parallel/agreement.h"
#include "crackle/parallel/collectives.h"
#include "crackle/parallel/exact_sum.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <set>
#include <string>
#include <utility>

namespace crackle::mechanics {

namespace {

struct TriangleGeometry {
  geometry::Point centroid;
  double area;
};

TriangleGeometry measure(const geometry::Subdomain& subdomain, const geometry::Triangle& nodes) {
  const auto& a = subdomain.nodes[index(nodes[0])];
  const auto& b = subdomain.nodes[index(nodes[1])];
  const auto& c = subdomain.nodes[index(nodes[2])];
  return {(a + b + c) / 3, norm(cross(b - a, c - a)) / 2};
}

/// A triangle is counted by the rank that owns its lowest node.
bool counts(const geometry::Subdomain& subdomain, const geometry::Triangle& nodes) {
  const auto lowest = *std::ranges::min_element(
      nodes, {}, [&](std::int32_t node) { return subdomain.layout.number[index(node)]; });
  return lowest < subdomain.layout.n_owned;
}

/// Region and faces of a condition.
struct Surfaces {
  geometry::ConditionRegion region;
  std::vector<Vector> outward;  // unit normal of every face of the body
};

std::vector<std::int32_t> held_nodes(const geometry::ConditionRegion& region,
                                     const geometry::Subdomain& subdomain) {
  std::set<std::int32_t> nodes;
  for (const auto& triangle : subdomain.boundary) {
    const geometry::FacePart* part = region.on(triangle.surface);
    if (part == nullptr) continue;
    for (const auto node : triangle.nodes)
      if (node < subdomain.layout.n_owned && part->contains(subdomain.nodes[index(node)])) nodes.insert(node);
  }
  return {nodes.begin(), nodes.end()};
}

/// The part of a condition's region on this rank: tributary areas of its owned nodes.
struct LoadedFace {
  std::vector<std::int32_t> nodes;
  std::vector<double> area;
  double total_area = 0;  // sum of magnitudes over all ranks
  double resultant = 0;   // with signs
};

/// The mesh edges that form a line region, as pairs of node numbers in the realization: each once, though
/// shared by triangles, in the same order on every rank.
using LineEdges = std::map<std::pair<std::int64_t, std::int64_t>, std::array<std::int32_t, 2>>;

LineEdges line_edges(const geometry::ConditionRegion& region, const geometry::Subdomain& subdomain) {
  LineEdges edges;
  for (const auto& triangle : subdomain.boundary) {
    const geometry::FacePart* part = region.on(triangle.surface);
    if (part == nullptr) continue;
    for (std::size_t i = 0; i < 3; ++i) {
      std::array<std::int32_t, 2> ends{triangle.nodes[i], triangle.nodes[(i + 1) % 3]};
      const auto number = [&](std::int32_t node) { return subdomain.layout.number[index(node)]; };
      if (number(ends[0]) > number(ends[1])) std::swap(ends[0], ends[1]);
      if (std::ranges::all_of(ends, [&](auto node) { return part->contains(subdomain.nodes[index(node)]); }))
        edges.emplace(std::pair{number(ends[0]), number(ends[1])}, ends);
    }
  }
  return edges;
}

/// A line region, with lengths instead of areas, or a point region, with the number of points. Collective.
LoadedFace loaded_line(const parallel::Communicator& group, const geometry::ConditionRegion& region,
                       const geometry::Subdomain& subdomain) {
  std::map<std::int32_t, double> tributary;
  std::vector<double> counted;
  if (region.n_dimensions == 1) {
    for (const auto& [numbers, ends] : line_edges(region, subdomain)) {
      const double length = norm(subdomain.nodes[index(ends[1])] - subdomain.nodes[index(ends[0])]);
      if (ends[0] < subdomain.layout.n_owned) counted.push_back(length);
      for (const auto node : ends)
        if (node < subdomain.layout.n_owned) tributary[node] += length / 2;
    }
  } else {
    for (const auto node : held_nodes(region, subdomain)) {
      counted.push_back(1);
      tributary[node] = 1;
    }
  }
  LoadedFace line;
  line.resultant = line.total_area = parallel::exact_sum(group, counted);
  for (const auto& [node, length] : tributary) {
    line.nodes.push_back(node);
    line.area.push_back(length);
  }
  return line;
}

/// @param share of a face's area that counts
template <class Share>
LoadedFace loaded_face(const parallel::Communicator& group, const geometry::ConditionRegion& region,
                       const geometry::Subdomain& subdomain, Share&& share) {
  std::map<std::int32_t, double> tributary;
  std::vector<double> counted_areas;
  for (const auto& triangle : subdomain.boundary) {
    const geometry::FacePart* here = region.on(triangle.surface);
    if (here == nullptr) continue;
    const auto [centroid, area] = measure(subdomain, triangle.nodes);
    if (!here->contains(centroid)) continue;
    const double part = share(triangle.surface);
    if (part == 0) continue;
    if (counts(subdomain, triangle.nodes)) counted_areas.push_back(part * area);
    for (const auto node : triangle.nodes) {
      if (node < subdomain.layout.n_owned) tributary[node] += part * (area / 3);
    }
  }
  LoadedFace face;
  face.resultant = parallel::exact_sum(group, counted_areas);
  for (double& area : counted_areas) area = std::abs(area);
  face.total_area = parallel::exact_sum(group, counted_areas);
  for (const auto& [node, area] : tributary) {
    face.nodes.push_back(node);
    face.area.push_back(area);
  }
  return face;
}

/// Equal shares for all nodes of a condition. Collective.
ConditionNodes equal_shares(const parallel::Communicator& group, const std::vector<std::int32_t>& nodes) {
  parallel::agree(group);
  const auto n = parallel::all_reduce<std::int64_t>(group, std::ssize(nodes), MPI_SUM);
  return {nodes, std::vector<double>(nodes.size(), 1 / static_cast<double>(n))};
}

/// The whole region, regardless of direction. Collective.
LoadedFace loaded_region(const parallel::Communicator& group, const geometry::ConditionRegion& region,
                         const geometry::Subdomain& subdomain) {
  if (region.n_dimensions < 2) return loaded_line(group, region, subdomain);
  return loaded_face(group, region, subdomain, [](geometry::FaceId) { return 1.0; });
}

/// Shares of the loaded area or length, regardless of direction. Collective.
ConditionNodes area_shares(const parallel::Communicator& group, const geometry::ConditionRegion& region,
                           const geometry::Subdomain& subdomain) {
  LoadedFace face = loaded_region(group, region, subdomain);
  for (double& area : face.area) area /= face.total_area;
  return {std::move(face.nodes), std::move(face.area)};
}

std::vector<std::int32_t> tetrahedra_at(const std::vector<PrescribedMotion>& motions,
                                        const geometry::Subdomain& subdomain) {
  std::vector<std::uint8_t> is_held(subdomain.nodes.size(), 0);
  for (const auto& motion : motions)
    for (const auto node : motion.nodes) is_held[index(node)] = 1;
  std::vector<std::int32_t> tetrahedra;
  for (std::int32_t t = 0; t < subdomain.n_tetrahedra(); ++t)
    if (std::ranges::any_of(subdomain.tetrahedra[index(t)],
                            [&](std::int32_t node) { return is_held[index(node)] != 0; }))
      tetrahedra.push_back(t);
  return tetrahedra;
}

/// Dashpots on the nodes of a region, with their impedances. Collective.
Absorber make_absorber(const parallel::Communicator& group, const Surfaces& surfaces,
                       const geometry::Subdomain& subdomain, const input::Material& material) {
  const auto& [region, outward] = surfaces;
  const double along = material.density * dilatational_speed(material);
  const double across = material.density * shear_speed(material);
  std::map<std::int32_t, Symmetric> impedance;
  // One component at a time, by the tributary areas weighted with that component of each face.
  for (std::size_t k = 0; k < 6; ++k) {
    const LoadedFace part =
        loaded_face(group, region, subdomain, [&, &normals = outward](geometry::FaceId id) {
          const Vector& normal = normals[index(id)];
          return (along - across) * symmetric_product(normal, normal)[k] + (k < 3 ? across : 0);
        });
    for (std::size_t n = 0; n < part.nodes.size(); ++n) impedance[part.nodes[n]][k] = part.area[n];
  }
  Absorber absorber;
  for (const auto& [node, value] : impedance) {
    absorber.nodes.push_back(node);
    absorber.impedance.push_back(value);
  }
  return absorber;
}

/// The governing conditions, with the loaded area of pressures. Collective.
std::vector<GoverningCondition> governing_with_areas(const parallel::Communicator& group,
                                                     const input::Parameters& parameters,
                                                     const std::vector<Surfaces>& all_surfaces,
                                                     const geometry::Subdomain& subdomain) {
  std::vector<GoverningCondition> all = governing_conditions(parameters);
  for (GoverningCondition& one : all)
    if (parameters.boundaries[index(one.condition)].kind == input::BoundaryKind::pressure)
      one.area = loaded_region(group, all_surfaces[index(one.condition)].region, subdomain).total_area;
  return all;
}

/// Assigns each component of a node to one motion, drops motions left without nodes, and marks loads on
/// driven components. Collective.
void settle_shared_components(const parallel::Communicator& group, std::size_t n_owned,
                              BoundaryLoads& loads) {
  std::vector<std::uint8_t> taken(3 * n_owned);
  for (const bool is_fixed : {true, false}) {
    for (PrescribedMotion& motion : loads.motions) {
      if (motion.is_fixed != is_fixed) continue;
      std::erase_if(motion.nodes, [&](std::int32_t node) {
        return std::exchange(taken[index(node, motion.component)], std::uint8_t{1}) != 0;
      });
    }
  }
  parallel::agree(group);
  std::erase_if(loads.motions, [&](const PrescribedMotion& motion) {
    return !parallel::any_of_all(group, !motion.nodes.empty());
  });
  for (ForcePattern& pattern : loads.forces)
    for (const auto node : pattern.nodes) pattern.is_driven.push_back(taken[index(node, pattern.component)]);
}

/// Removes dashpots from components prescribed by a condition.
void leave_out_prescribed(const std::vector<PrescribedMotion>& motions, std::vector<Absorber>& absorbers) {
  // Indices in xx, yy, zz, yz, xz, xy that involve x, y and z.
  constexpr std::array<std::array<std::size_t, 3>, 3> with{{{0, 4, 5}, {1, 3, 5}, {2, 3, 4}}};
  for (Absorber& absorber : absorbers) {
    for (const auto& motion : motions) {
      for (const auto node : motion.nodes) {
        const auto place = std::ranges::lower_bound(absorber.nodes, node);
        if (place == absorber.nodes.end() || *place != node) continue;
        for (const std::size_t k : with[index(motion.component)])
          absorber.impedance[index(place - absorber.nodes.begin())][k] = 0;
      }
    }
  }
}

}  // namespace

double LoadCurve::at(double time) const {
  if (history_.empty()) return value_ + rate_ * time;
  if (time <= history_.front().first) return value_ * history_.front().second;
  for (std::size_t i = 1; i < history_.size(); ++i) {
    const auto [t0, f0] = history_[i - 1];
    const auto [t1, f1] = history_[i];
    if (time <= t1) return value_ * (f0 + (f1 - f0) * ((time - t0) / (t1 - t0)));
  }
  return value_ * history_.back().second;
}

double LoadCurve::slope(double time) const {
  if (history_.empty()) return rate_;
  for (std::size_t i = 1; i < history_.size(); ++i) {
    const auto [t0, f0] = history_[i - 1];
    const auto [t1, f1] = history_[i];
    if (time >= t0 && time < t1) return value_ * (f1 - f0) / (t1 - t0);
  }
  return 0;
}

double LoadCurve::slope(double time, const StepSpan& step) const {
  return has_kink(step) ? (at(step.end) - at(step.begin)) / (step.end - step.begin) : slope(time);
}

double LoadCurve::integral(double time) const {
  if (history_.empty()) return value_ * time + 0.5 * rate_ * time * time;
  double sum = 0;
  double from = 0;
  while (from < time) {
    const double to = std::min(time, next_kink(from));
    sum += 0.5 * (at(from) + at(to)) * (to - from);
    from = to;
  }
  return sum;
}

double LoadCurve::next_kink(double time) const {
  for (const auto& [t, factor] : history_) {
    if (t > time) return t;
  }
  return infinity;
}

bool LoadCurve::has_kink(const StepSpan& step) const {
  // The times of kicks at the end of the step may be rounded up.
  return next_kink(step.begin) <= step.end + 1e-6 * (step.end - step.begin);
}

double PrescribedMotion::velocity(double time, const StepSpan& step) const {
  return curve.has_kink(step) ? (displacement(step.end) - displacement(step.begin)) / (step.end - step.begin)
                              : velocity(time);
}

double BoundaryLoads::next_kink(double time) const {
  double kink = infinity;
  for (const auto& force : forces) kink = std::min(kink, force.amplitude.next_kink(time));
  for (const auto& motion : motions) kink = std::min(kink, motion.curve.next_kink(time));
  return kink;
}

bool BoundaryLoads::grows_after(double time) const {
  const auto grows = [time](const LoadCurve& curve) {
    return curve.slope(time) != 0 || curve.next_kink(time) < infinity;
  };
  return std::ranges::any_of(forces, [&](const auto& force) { return grows(force.amplitude); }) ||
         std::ranges::any_of(motions, [&](const auto& motion) {
           return grows(motion.curve) || (motion.is_velocity && motion.curve.at(time) != 0);
         });
}

void BoundaryLoads::end_loads(const parallel::Communicator& group, const NodesOfConditions& nodes) {
  const auto ends = [&](int condition, std::int32_t node) {
    return std::ranges::binary_search(nodes[index(condition)], node);
  };
  // Sums over what is left, so that the result does not depend on the sequence in which loads ended.
  for (ForcePattern& pattern : forces) {
    for (std::size_t i = 0; i < pattern.nodes.size(); ++i)
      if (ends(pattern.condition, pattern.nodes[i])) pattern.weight[i] = 0;
    std::vector<double> magnitudes = pattern.weight;
    for (double& weight : magnitudes) weight = std::abs(weight);
    parallel::agree(group);
    pattern.left_weight = parallel::exact_sum(group, magnitudes);
    pattern.left_resultant = parallel::exact_sum(group, pattern.weight);
  }
  for (std::size_t c = 0; c < conditions.size(); ++c) {
    ConditionNodes& condition = conditions[c];
    if (!parallel::any_of_all(group, !nodes[c].empty())) continue;
    condition.has_ended.resize(condition.nodes.size());
    std::vector<double> acting = condition.share;
    for (std::size_t i = 0; i < condition.nodes.size(); ++i) {
      if (ends(static_cast<int>(c), condition.nodes[i])) condition.has_ended[i] = 1;
      if (!condition.acts_at(i)) acting[i] = 0;
    }
    condition.acting_share = parallel::exact_sum(group, acting);
  }
}

void BoundaryLoads::add_forces(double time, std::span<double> force) const {
  for (const auto& pattern : forces) {
    const double amplitude = pattern.amplitude.at(time);
    for (std::size_t i = 0; i < pattern.nodes.size(); ++i) {
      force[index(pattern.nodes[i], pattern.component)] += amplitude * pattern.weight[i];
    }
  }
}

void BoundaryLoads::set_displacements(double time, std::span<double> displacement) const {
  for (const auto& motion : motions) {
    const double value = motion.displacement(time);
    for (const auto node : motion.nodes) {
      displacement[index(node, motion.component)] = value;
    }
  }
}

BoundaryLoads make_boundary_loads(const parallel::Communicator& group, const input::Parameters& parameters,
                                  const geometry::Subdomain& subdomain) {
  // By condition.
  const std::vector<Surfaces> all_surfaces = parallel::agree(group, [&] {
    const auto body = geometry::make_body(parameters.specimen);
    std::vector<Vector> outward;
    for (const geometry::Face& face : body->faces()) outward.push_back(face.outward);
    std::vector<Surfaces> found;
    for (auto& region : geometry::condition_regions(*body, parameters.boundaries))
      found.push_back({std::move(region), outward});
    return found;
  });
  BoundaryLoads loads;
  int number = 0;
  for (const auto& condition : parameters.boundaries) {
    const auto& [region, outward] = all_surfaces[index(number++)];
    const auto refuse_empty = [&](bool empty, const char* what) {
      if (!empty) return;
      throw parallel::AgreedError(0, "boundary " + std::to_string(number) + " on " + condition.on +
                                         ": its region contains no " + what +
                                         " of the mesh; enlarge the region or refine the mesh");
    };
    const bool is_load =
        condition.kind == input::BoundaryKind::force || condition.kind == input::BoundaryKind::traction;
    if (condition.kind == input::BoundaryKind::pressure) {
      double total_area = 0;
      for (int component = 0; component < 3; ++component) {
        const LoadedFace face =
            loaded_face(group, region, subdomain, [&outward = outward, component](geometry::FaceId id) {
              return -outward[index(id)][static_cast<std::size_t>(component)];
            });
        total_area += face.total_area;
        LoadCurve amplitude(condition.value[0], condition.rate[0], condition.history);
        if (amplitude.is_zero() || face.total_area == 0) continue;
        loads.forces.push_back({component, std::move(amplitude), face.nodes, face.area, face.total_area,
                                face.resultant, number - 1});
      }
      refuse_empty(total_area == 0, "boundary triangle");
      loads.conditions.push_back(area_shares(group, region, subdomain));
    } else if (condition.kind == input::BoundaryKind::absorbing) {
      Absorber absorber =
          make_absorber(group, all_surfaces[index(number - 1)], subdomain, parameters.material);
      parallel::agree(group);
      refuse_empty(!parallel::any_of_all(group, !absorber.nodes.empty()), "boundary triangle");
      absorber.condition = number - 1;
      loads.absorbers.push_back(std::move(absorber));
      loads.conditions.push_back(area_shares(group, region, subdomain));
    } else if (is_load) {
      const LoadedFace face = loaded_region(group, region, subdomain);
      refuse_empty(face.total_area == 0, "boundary triangle");
      for (int component = 0; component < 3; ++component) {
        const auto c = static_cast<std::size_t>(component);
        LoadCurve amplitude(condition.value[c], condition.rate[c], condition.history);
        if (amplitude.is_zero()) continue;
        ForcePattern pattern{component,       std::move(amplitude), face.nodes, face.area,
                             face.total_area, face.resultant,       number - 1};
        if (condition.kind == input::BoundaryKind::force) {
          for (auto& weight : pattern.weight) weight /= face.total_area;
          pattern.total_weight = pattern.resultant = 1;
        }
        loads.forces.push_back(std::move(pattern));
      }
      loads.conditions.push_back(area_shares(group, region, subdomain));
    } else {
      const std::vector<std::int32_t> nodes = held_nodes(region, subdomain);
      parallel::agree(group);
      refuse_empty(!parallel::any_of_all(group, !nodes.empty()), "node");
      for (int component = 0; component < 3; ++component) {
        const auto c = static_cast<std::size_t>(component);
        if (!condition.components[c]) continue;
        PrescribedMotion motion;
        motion.component = component;
        motion.is_fixed = condition.kind == input::BoundaryKind::fix;
        motion.is_velocity = condition.kind == input::BoundaryKind::velocity;
        if (!motion.is_fixed)
          motion.curve = LoadCurve(condition.value[c], condition.rate[c], condition.history);
        motion.nodes = nodes;
        motion.condition = number - 1;
        loads.motions.push_back(std::move(motion));
      }
      loads.conditions.push_back(equal_shares(group, nodes));
    }
  }
  settle_shared_components(group, index(subdomain.layout.n_owned), loads);
  leave_out_prescribed(loads.motions, loads.absorbers);
  loads.held_tetrahedra = tetrahedra_at(loads.motions, subdomain);
  loads.governing = governing_with_areas(group, parameters, all_surfaces, subdomain);
  return loads;
}

}  // namespace crackle::mechanics
