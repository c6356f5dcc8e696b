// SPDX-License-Identifier: GPL-3.0-or-later
#include "dynamics/tool_term.h"

#include "common/index.h"
#include "dynamics/contact_stiffness.h"
#include "parallel/agreement.h"
#include "parallel/collectives.h"
#include "parallel/exact_sum.h"

#include <fmt/format.h>

#include <algorithm>
#include <bit>
#include <cmath>
#include <iterator>
#include <limits>
#include <numbers>
#include <stdexcept>

namespace crackle::dynamics {

namespace {

/// A tool this close to the body, in spacings, touches its nearest node; one so far inside is refused.
constexpr double touching_share = 0.05;
constexpr double overlap_share = 0.25;
/// The body is searched for nodes near a tool when the room that the last search left is this many times what
/// node and tool have moved in the last step.
constexpr double least_room = 8;
/// Searches reach at least so many spacings, or steps.
constexpr double search_spacings = 1, search_steps = 64;
/// The nodes that a tool touches may raise the squared frequency of its mass to this share of ContactScale's.
constexpr double mass_share = 0.25;
/// In equilibrium, nodes that a tool almost touches resist with this share of the stiffness of contact.
constexpr double stabilizing_share = 1e-4;

double spacing_of(double node_volume) {
  return std::cbrt(std::numbers::sqrt2 * node_volume);
}

Vector place(const geometry::Subdomain& subdomain, std::int32_t node) {
  return subdomain.nodes[index(node)];
}

Vector displacement_of(std::span<const double> field, std::int32_t node) {
  return {field[index(node, 0)], field[index(node, 1)], field[index(node, 2)]};
}

/// What is prescribed for a tool, by component.
std::array<mechanics::LoadCurve, 3> curves_of(const input::Tool& tool) {
  std::array<mechanics::LoadCurve, 3> curves;
  const Vector value = tool.has_mass() && tool.gives_velocity() ? Vector{} : tool.given();
  for (std::size_t i = 0; i < 3; ++i) curves[i] = {value[i], tool.rate[i], tool.history};
  return curves;
}

}  // namespace

ToolTerm::ToolTerm(const MotionContext& context, const std::vector<input::Tool>& tools,
                   std::vector<ToolAtRest>& at_rest, std::int32_t nodes_per_block)
    : context_(context),
      tools_(&tools),
      at_rest_(&at_rest),
      nodes_per_block_(nodes_per_block),
      driven_(context.body->operators().node_mass.size()),
      stiffness_(tool_stiffness(*context.group, context.body->subdomain(), context.body->operators(),
                                context.contact)),
      moving_(tools.size()) {
  for (const auto& motion : context.loads->motions)
    for (const auto node : motion.nodes)
      driven_[index(node)] = static_cast<std::uint8_t>(driven_[index(node)] | 1 << motion.component);
  const double volume = parallel::exact_sum(*context.group, context.body->operators().node_volume);
  spacing_ = spacing_of(volume / static_cast<double>(context.body->subdomain().layout.n_global));
  for (std::size_t t = 0; t < tools.size(); ++t) {
    moving_[t].curve = curves_of(tools[t]);
    moving_[t].friction = tools[t].friction.value_or(context.contact.friction);
    moving_[t].displacement = at_rest[t].displacement;
    if (tools[t].has_mass()) moving_[t].velocity = tools[t].velocity.value_or(Vector{});
    if (tools[t].turns())
      moving_[t].turning.emplace(moment_of_inertia(tools[t]), tools[t].turning(),
                                 tools[t].angular_velocity.value_or(Vector{}));
  }
  soften_light_tools();
  find_offsets();
}

void ToolTerm::soften_light_tools() {
  if (std::ranges::none_of(*tools_, &input::Tool::has_mass)) return;
  const parallel::Communicator& group = *context_.group;
  const auto areas = parallel::agree(group, [&] { return surface_areas(context_.body->subdomain()); });
  double per_area = 0, largest_area = 0;
  for (std::size_t n = 0; n < areas.size(); ++n)
    if (areas[n] > 0) {
      per_area = std::max(per_area, stiffness_[n] / areas[n]);
      largest_area = std::max(largest_area, areas[n]);
    }
  per_area = parallel::largest_of_all(group, per_area);
  largest_area = parallel::largest_of_all(group, largest_area);
  const double half_surface = 0.5 * parallel::exact_sum(group, areas);
  for (std::size_t t = 0; t < tools_->size(); ++t) {
    const input::Tool& tool = (*tools_)[t];
    // The nodes that it touches stand for its section and half a spacing around it.
    const double around = std::pow(std::sqrt(largest_section(tool)) + std::sqrt(largest_area), 2);
    const double stiffness = per_area * std::min(half_surface, around);
    if (tool.has_mass())
      moving_[t].stiffness_share =
          std::min(1.0, mass_share * context_.contact.rate * least_mass(tool) / stiffness);
  }
}

void ToolTerm::find_offsets() {
  const auto& subdomain = context_.body->subdomain();
  parallel::check_peers(*context_.group);
  for (std::size_t t = 0; t < tools_->size(); ++t) {
    const input::Tool& tool = (*tools_)[t];
    constexpr auto none = std::numeric_limits<std::int64_t>::max();
    double least = infinity;
    std::size_t nearest = 0;
    for (std::size_t n = 0; n < driven_.size(); ++n) {
      const double distance = surface_from(tool, subdomain.nodes[n] - tool.at).distance;
      if (distance < least) {
        least = distance;
        nearest = n;
      }
    }
    const double agreed = parallel::all_reduce(*context_.group, least, MPI_MIN);
    const std::int64_t own = least == agreed && !driven_.empty() ? subdomain.layout.number[nearest] : none;
    const std::int64_t number = parallel::all_reduce(*context_.group, own, MPI_MIN);
    const double spacing = parallel::largest_of_all(
        *context_.group, own == number ? spacing_of(context_.body->operators().node_volume[nearest]) : 0);
    if (agreed < -overlap_share * spacing)
      throw parallel::AgreedError(
          0,
          fmt::format("tool \"{}\" overlaps the body by {:.3g} mm at the start; move it, or make it smaller",
                      name_of(tool, t), -1e3 * agreed));
    if (agreed < touching_share * spacing)
      moving_[t].offset = agreed;
    else if (tool.force && !tool.has_mass())
      throw parallel::AgreedError(
          0, fmt::format(
                 "tool \"{}\" is {:.3g} mm from the body's nearest node, so that nothing balances the force "
                 "on it; move it there, or give a displacement",
                 name_of(tool, t), 1e3 * agreed));
  }
}

ToolTerm::Pose ToolTerm::pose_at(std::size_t tool, double time) const {
  const input::Tool& given = (*tools_)[tool];
  const Moving& moving = moving_[tool];
  if (given.has_mass() && is_moving_) {
    Pose pose{.displacement = moving.displacement + (time - time_) * moving.velocity};
    if (moving.turning) pose.orientation = moving.turning->orientation_after(time - time_);
    return pose;
  }
  if (given.is_driven_by_force()) return {.displacement = moving.displacement};
  Pose pose;
  for (std::size_t i = 0; i < 3; ++i)
    pose.displacement[i] = given.displacement ? moving.curve[i].at(time) : moving.curve[i].integral(time);
  return pose;
}

Vector ToolTerm::velocity_at(std::size_t tool, double time, const mechanics::StepSpan* step) const {
  const input::Tool& given = (*tools_)[tool];
  const Moving& moving = moving_[tool];
  if (given.has_mass()) return is_moving_ ? moving.velocity : Vector{};
  if (given.is_driven_by_force()) return {};
  Vector velocity{};
  for (std::size_t i = 0; i < 3; ++i)
    velocity[i] = !given.displacement ? moving.curve[i].at(time)
                  : step != nullptr   ? moving.curve[i].slope(time, *step)
                                      : moving.curve[i].slope(time);
  return velocity;
}

double ToolTerm::turning_speed(std::size_t tool) const {
  const auto& turning = moving_[tool].turning;
  return turning ? norm(turning->spin()) * norm(farthest_point((*tools_)[tool])) : 0;
}

Vector ToolTerm::arm(std::size_t tool, std::int32_t node, const Vector& displacement,
                     const Pose& pose) const {
  return place(context_.body->subdomain(), node) - (*tools_)[tool].at + (displacement - pose.displacement);
}

ToolTerm::Touch ToolTerm::touch(std::size_t tool, std::int32_t node, const Vector& displacement,
                                const Pose& pose) const {
  Touch touch;
  const Vector from = pose.in(arm(tool, node, displacement, pose));
  touch.relative = pose.orientation ? from - (place(context_.body->subdomain(), node) - (*tools_)[tool].at)
                                    : displacement - pose.displacement;
  const ToolSurface surface = surface_from((*tools_)[tool], from);
  touch.depth = moving_[tool].offset - surface.distance;
  touch.normal = surface.normal;
  return touch;
}

Vector ToolTerm::stretch(std::size_t tool, const Touch& touch, const Vector& anchor) const {
  const Vector along = touch.from(anchor);
  const double length = norm(along), most = moving_[tool].friction * touch.depth;
  return length > most ? most / length * along : along;
}

Vector ToolTerm::force(std::size_t tool, std::int32_t node, const Touch& touch, const Vector* anchor) const {
  Vector push = touch.depth * touch.normal;
  if (anchor != nullptr) push = push - stretch(tool, touch, *anchor);
  return stiffness(tool, node) * push;
}

void ToolTerm::slide(std::size_t tool, const Touch& touch, Vector& anchor) const {
  anchor = touch.relative - stretch(tool, touch, anchor);
}

template <class Visit>
void ToolTerm::for_touches(double time, std::span<const double> displacement, double gap,
                           const Visit& visit) const {
  for (std::size_t t = 0; t < tools_->size(); ++t) {
    const Pose pose = pose_at(t, time);
    for (std::int32_t n = 0; index(n) < driven_.size(); ++n) {
      const Touch one = touch(t, n, displacement_of(displacement, n), pose);
      if (one.depth > -gap) visit(t, n, one, pose);
    }
  }
}

const Vector* ToolTerm::anchor_of(std::size_t tool, std::int32_t node) const {
  if (moving_[tool].friction == 0) return nullptr;
  if (is_moving_) {
    const auto found = std::ranges::lower_bound(contacts_, std::pair{node, tool}, {}, &Contact::place);
    const bool is_there = found != contacts_.end() && found->node == node && found->tool == tool;
    return is_there && found->anchor ? &*found->anchor : nullptr;
  }
  const auto& springs = (*at_rest_)[tool].springs;
  const auto found = springs.find(node);
  return found == springs.end() ? nullptr : &found->second.anchor;
}

void ToolTerm::start(double time, const MotionState&) {
  is_moving_ = true;
  time_ = time;
  moved_.resize(driven_.size());
  first_contact_.assign(index(std::max(1, (context_.body->subdomain().layout.n_owned + nodes_per_block_ - 1) /
                                              nodes_per_block_)) +
                            1,
                        0);
  for (std::size_t t = 0; t < tools_->size(); ++t)
    for (const auto& [node, spring] : (*at_rest_)[t].springs) {
      // It has taken before what its spring holds.
      const double held = 0.5 * stiffness(t, node) * dot(spring.stretch, spring.stretch);
      contacts_.push_back({.node = node, .tool = t, .taken = held, .held = held, .anchor = spring.anchor});
    }
  std::ranges::sort(contacts_, {}, &Contact::place);
}

void ToolTerm::find_contacts(double time, const MovingNodes& nodes, double margin) {
  std::vector<Contact> kept;
  std::ranges::copy_if(contacts_, std::back_inserter(kept), &Contact::has_touched);
  std::ranges::sort(kept, {}, &Contact::place);
  contacts_.clear();
  std::vector<Pose> poses;
  for (std::size_t t = 0; t < tools_->size(); ++t) poses.push_back(pose_at(t, time));
  auto next = kept.begin();
  for (std::int32_t n = 0; index(n) < driven_.size(); ++n)
    for (std::size_t t = 0; t < tools_->size(); ++t) {
      if (next != kept.end() && next->place() == std::pair{n, t})
        contacts_.push_back(*next++);
      else if (touch(t, n, nodes.whole_displacement(n), poses[t]).depth > -margin)
        contacts_.push_back({.node = n, .tool = t});
    }
  std::ranges::fill(first_contact_, contacts_.size());
  for (std::size_t c = contacts_.size(); c-- > 0;)
    first_contact_[index(contacts_[c].node / nodes_per_block_)] = c;
  for (std::size_t b = first_contact_.size() - 1; b-- > 0;)
    first_contact_[b] = std::min(first_contact_[b], first_contact_[b + 1]);
  room_ = margin;
  must_find_ = false;
  has_new_contacts_ = true;
}

void ToolTerm::before_kick(std::size_t block, const Substep& substep, MovingNodes& nodes) {
  if (must_find_) find_contacts(substep.kick_time, nodes, search_spacings * spacing_);
  for (std::size_t c = first_contact_[block]; c < first_contact_[block + 1]; ++c)
    for (int i = 0; i < 3; ++i) contacts_[c].velocity[index(i)] = nodes.velocity(contacts_[c].node, i);
}

void ToolTerm::after_kick(std::size_t block, const Substep& substep, MovingNodes& nodes) {
  for (std::size_t c = first_contact_[block]; c < first_contact_[block + 1]; ++c) {
    Contact& contact = contacts_[c];
    const Moving& tool = moving_[contact.tool];
    const Pose pose = pose_at(contact.tool, substep.kick_time);
    const Vector displacement = nodes.whole_displacement(contact.node);
    const Touch now = touch(contact.tool, contact.node, displacement, pose);
    if (now.depth <= 0) continue;
    if (!contact.anchor) contact.anchor = now.relative;
    const Vector force = pose.out(
        this->force(contact.tool, contact.node, now, tool.friction > 0 ? &*contact.anchor : nullptr));
    const Vector normal = pose.out(now.normal);
    Vector velocity = velocity_at(contact.tool, substep.kick_time, &substep.step);
    if (tool.turning) {
      const Vector arm = this->arm(contact.tool, contact.node, displacement, pose);
      velocity = velocity + cross(tool.turning->spin(), arm);
      contact.moment = contact.moment + substep.kick * cross(arm, force);
    }
    const double push = dot(force, normal);
    for (int i = 0; i < 3; ++i) {
      if (is_driven(contact.node, i))
        // The support takes the force, and its work.
        contact.work -= substep.kick * force[index(i)] * contact.velocity[index(i)];
      else
        nodes.kick(contact.node, i, substep.kick, force[index(i)], contact.remainder[index(i)]);
      contact.impulse[index(i)] += substep.kick * force[index(i)];
      // The force along the surface takes work from the node and the tool at the mean velocity of the whole
      // kick, as the other forces nearly balance this one.
      const double before = contact.velocity[index(i)];
      const double after = is_driven(contact.node, i) ? before : nodes.velocity(contact.node, i);
      const double sliding = 0.5 * (before + after) - velocity[index(i)];
      contact.taken -= substep.kick * (force[index(i)] - push * normal[index(i)]) * sliding;
      // What moves by forces does its work when it takes over the impulse.
      if (!(*tools_)[contact.tool].has_mass())
        contact.work += substep.kick * force[index(i)] * velocity[index(i)];
    }
  }
}

double ToolTerm::move_tools(const mechanics::StepSpan& step) {
  // Impulses, then their moments.
  const std::size_t first_moment = 3 * tools_->size();
  std::vector<std::vector<double>> impulses(
      std::ranges::any_of(*tools_, &input::Tool::turns) ? 2 * first_moment : first_moment);
  const bool moves_by_forces = std::ranges::any_of(*tools_, &input::Tool::has_mass);
  if (moves_by_forces)
    for (const Contact& contact : contacts_)
      for (std::size_t i = 0; i < 3; ++i) {
        const std::size_t place = 3 * contact.tool + i;
        if (contact.impulse[i] != 0) impulses[place].push_back(contact.impulse[i]);
        if (contact.moment[i] != 0) impulses[first_moment + place].push_back(contact.moment[i]);
      }
  const double duration = step.end - step.begin;
  double fastest = 0;
  const auto sums = moves_by_forces ? parallel::exact_sums(*context_.group, impulses) : std::vector<double>();
  for (std::size_t t = 0; t < tools_->size(); ++t) {
    const Vector before = velocity_at(t, step.begin, &step);
    fastest = std::max(fastest, norm(before) + turning_speed(t));
    if (!(*tools_)[t].has_mass()) continue;
    Moving& moving = moving_[t];
    for (int i = 0; i < 3; ++i) {
      if (!(*tools_)[t].moves_along(i)) continue;
      const auto& force = moving.curve[index(i)];
      const double applied = (*tools_)[t].force ? force.integral(step.end) - force.integral(step.begin) : 0;
      const double last = moving.velocity[index(i)];
      moving.velocity[index(i)] += (applied - sums[3 * t + index(i)]) / (*tools_)[t].mass;
      const double mean = 0.5 * (last + moving.velocity[index(i)]);
      moving.displacement[index(i)] += duration * mean;
      moving.work += sums[3 * t + index(i)] * mean;
    }
    if (moving.turning) {
      const double* const sum = &sums[first_moment + 3 * t];
      const Vector moment{sum[0], sum[1], sum[2]};
      moving.work += dot(moment, moving.turning->turn(-1.0 * moment, duration));
    }
    fastest = std::max(fastest, norm(moving.velocity) + turning_speed(t));
  }
  time_ = step.end;
  return fastest;
}

void ToolTerm::settle_anchors(const MovingNodes& nodes) {
  for (Contact& contact : contacts_) {
    contact.impulse = contact.moment = {};
    if (!contact.anchor) continue;
    const Touch now = touch(contact.tool, contact.node, nodes.whole_displacement(contact.node),
                            pose_at(contact.tool, time_));
    contact.held = 0;
    if (now.depth <= 0) {
      contact.anchor.reset();
      continue;
    }
    slide(contact.tool, now, *contact.anchor);
    const Vector held = stretch(contact.tool, now, *contact.anchor);
    contact.held = 0.5 * stiffness(contact.tool, contact.node) * dot(held, held);
  }
}

void ToolTerm::end_step(const mechanics::StepSpan& step, MovingNodes& nodes, const Drives&) {
  const double fastest = move_tools(step);
  settle_anchors(nodes);
  // The nodes near the tools are those that can touch them before the next search.
  nodes.movements(moved_);
  double farthest = 0;
  for (const Vector& moved : moved_) farthest = std::max(farthest, norm(moved));
  const double approach = farthest + (step.end - step.begin) * fastest;
  room_ -= approach;
  if (room_ < least_room * approach)
    find_contacts(time_, nodes, std::max(search_spacings * spacing_, search_steps * approach));
}

void ToolTerm::add_supplied(double, const MotionState&, std::vector<double>& sum) const {
  for (const Contact& contact : contacts_) sum.push_back(contact.work);
  if (context_.group->is_root())
    for (const Moving& one : moving_) sum.push_back(one.work);
}

bool ToolTerm::dissipates() const {
  return std::ranges::any_of(moving_, [](const Moving& one) { return one.friction > 0; });
}

void ToolTerm::add_dissipated(std::vector<double>& sum) const {
  for (const Contact& contact : contacts_) sum.push_back(contact.lost());
  for (const Moving& one : moving_)
    for (const auto& [node, lost] : one.lost) sum.push_back(lost);
}

void ToolTerm::add_stored(const parallel::NodeField& displacement, std::vector<double>& sum) const {
  for_touches(time_, displacement.owned(), 0,
              [&](std::size_t tool, std::int32_t node, const Touch& now, const Pose&) {
                double square = now.depth * now.depth;
                if (const Vector* const anchor = anchor_of(tool, node)) {
                  const Vector held = stretch(tool, now, *anchor);
                  square += dot(held, held);
                }
                sum.push_back(0.5 * stiffness(tool, node) * square);
              });
}

Demand ToolTerm::demand(double from, double to) const {
  Demand demand;
  for (std::size_t t = 0; t < tools_->size(); ++t) {
    demand.holds = demand.holds || !(*tools_)[t].has_mass();
    const auto& curve = moving_[t].curve;
    for (double time = from; time < to;
         time =
             std::ranges::min({curve[0].next_kink(time), curve[1].next_kink(time), curve[2].next_kink(time)}))
      demand.velocity = std::max(demand.velocity, norm(velocity_at(t, time, nullptr)));
    demand.velocity = std::max({demand.velocity, norm(velocity_at(t, to, nullptr)),
                                (*tools_)[t].has_mass() ? norm(moving_[t].velocity) + turning_speed(t) : 0});
  }
  return demand;
}

void ToolTerm::add_unit_loads(std::vector<UnitLoad>& loads) const {
  for (std::size_t t = 0; t < tools_->size(); ++t)
    for (const auto& curve : moving_[t].curve)
      if (!curve.is_zero())
        loads.push_back({UnitLoad::Kind::other, &curve, {}, 0, (*tools_)[t].gives_velocity()});
}

NodeResponse ToolTerm::response(std::size_t tool, std::int32_t node, const Touch& now) const {
  const bool is_inside = now.depth >= -1e-12 * spacing_;
  const double contact = stiffness(tool, node), barely = stabilizing_share * contact;
  NodeResponse response;
  response.node = node;
  // Along the surface a node that sticks is held. One that slides is held across its way, by a force that
  // turns with it; along its way the force does not change.
  double along = moving_[tool].friction > 0 ? barely : 0;
  double on_its_way = along;
  Vector way{};
  if (is_inside) {
    const Vector* const anchor = anchor_of(tool, node);
    if (now.depth > 0) response.force = force(tool, node, now, anchor);
    if (anchor != nullptr) {
      way = now.from(*anchor);
      const double most = moving_[tool].friction * std::max(now.depth, 0.0), length = norm(way);
      along = length <= most ? contact : std::max(barely, contact * most / length);
      if (length <= most) on_its_way = along;
      if (length > 0) way = (1 / length) * way;
    }
  }
  response.stiffness =
      mechanics::symmetric_product(((is_inside ? contact : barely) - along) * now.normal, now.normal);
  const mechanics::Symmetric less = mechanics::symmetric_product((on_its_way - along) * way, way);
  for (std::size_t i = 0; i < 6; ++i) response.stiffness[i] += less[i];
  for (std::size_t i = 0; i < 3; ++i) response.stiffness[i] += along;
  return response;
}

void ToolTerm::add_responses(double time, std::span<const double> displacement,
                             std::vector<NodeResponse>& responses) const {
  for_touches(time, displacement, touching_share * spacing_,
              [&](std::size_t tool, std::int32_t node, const Touch& now, const Pose&) {
                NodeResponse& one = responses.emplace_back(response(tool, node, now));
                for (int i = 0; i < 3; ++i)
                  if (is_driven(node, i)) one.force[index(i)] = 0;
              });
}

std::vector<double*> ToolTerm::unknowns() {
  std::vector<double*> all;
  for (std::size_t t = 0; t < tools_->size(); ++t)
    for (std::size_t i = 0; i < 3; ++i)
      if (is_unknown(t, i)) all.push_back(&moving_[t].displacement[i]);
  return all;
}

void ToolTerm::add_unknown_responses(double time, std::span<const double> displacement,
                                     std::vector<UnknownResponse>& responses) const {
  std::vector<std::array<UnknownResponse, 3>> of_tools(tools_->size());
  std::vector<std::vector<double>> forces(6 * tools_->size());
  for_touches(time, displacement, touching_share * spacing_,
              [&](std::size_t tool, std::int32_t node, const Touch& now, const Pose&) {
                const NodeResponse one = response(tool, node, now);
                for (std::size_t i = 0; i < 3; ++i) {
                  if (!is_unknown(tool, i)) continue;
                  Vector along{};
                  along[i] = 1;
                  Vector pull = mechanics::apply(one.stiffness, along);
                  forces[6 * tool + i].push_back(-one.force[i]);
                  forces[6 * tool + 3 + i].push_back(pull[i]);
                  for (int k = 0; k < 3; ++k)
                    if (is_driven(node, k)) pull[index(k)] = 0;
                  of_tools[tool][i].coupling.emplace_back(node, pull);
                }
              });
  const auto sums = parallel::exact_sums(*context_.group, forces);
  for (std::size_t t = 0; t < tools_->size(); ++t)
    for (std::size_t i = 0; i < 3; ++i) {
      if (!is_unknown(t, i)) continue;
      UnknownResponse& one = of_tools[t][i];
      one.load = moving_[t].curve[i].at(time);
      one.force = one.load + sums[6 * t + i];
      one.stiffness = sums[6 * t + 3 + i];
      responses.push_back(std::move(one));
    }
}

void ToolTerm::add_supports(std::vector<mechanics::Support>& supports) const {
  constexpr double negligible = 0.05;
  for (std::size_t t = 0; t < tools_->size(); ++t)
    for (std::int32_t n = 0; index(n) < driven_.size(); ++n) {
      const Touch now = touch(t, n, {}, {});
      if (now.depth <= -touching_share * spacing_) continue;
      unsigned components = moving_[t].friction > 0 ? 7 : 0;
      for (std::size_t i = 0; i < 3; ++i)
        if (std::abs(now.normal[i]) > negligible) components |= 1U << i;
      supports.push_back({n, static_cast<std::uint8_t>(components)});
    }
}

void ToolTerm::rest_at(double time, const parallel::NodeField& displacement) {
  time_ = time;
  for (std::size_t t = 0; t < tools_->size(); ++t) {
    const Pose pose = pose_at(t, time);
    (*at_rest_)[t].displacement = pose.displacement;
    if (moving_[t].friction == 0) continue;
    const auto& before = (*at_rest_)[t].springs;
    std::map<std::int32_t, ToolAtRest::Spring> springs;
    for (std::int32_t n = 0; index(n) < driven_.size(); ++n) {
      const Touch now = touch(t, n, displacement_of(displacement.owned(), n), pose);
      const bool is_near = now.depth >= -touching_share * spacing_;
      const auto found = before.find(n);
      // A node that comes into contact is held from where it was in the last equilibrium.
      ToolAtRest::Spring spring{.anchor = now.relative};
      if (found != before.end()) {
        if (now.depth > 0) {
          spring.stretch = stretch(t, now, found->second.anchor);
          spring.anchor = now.relative - spring.stretch;
        }
        // The force has changed evenly on the way, as those of the account do.
        const Vector slip = now.from(found->second.anchor) - spring.stretch;
        moving_[t].lost[n] += 0.5 * stiffness(t, n) * dot(found->second.stretch + spring.stretch, slip);
      }
      if (is_near) springs.emplace(n, spring);
    }
    (*at_rest_)[t].springs = std::move(springs);
  }
}

void ToolTerm::measure(double time, const parallel::NodeField& displacement, const parallel::NodeField*,
                       LoadState& state) const {
  std::vector<std::vector<double>> terms(4 * tools_->size());
  for_touches(time, displacement.owned(), 0,
              [&](std::size_t tool, std::int32_t node, const Touch& now, const Pose& pose) {
                const Vector push = pose.out(force(tool, node, now, anchor_of(tool, node)));
                for (int i = 0; i < 3; ++i) {
                  terms[4 * tool + index(i)].push_back(push[index(i)]);
                  if (is_driven(node, i)) state.borne.emplace_back(index(node, i), push[index(i)]);
                }
              });
  for (const Contact& contact : contacts_) terms[4 * contact.tool + 3].push_back(contact.lost());
  for (std::size_t t = 0; t < tools_->size(); ++t)
    for (const auto& [node, lost] : moving_[t].lost) terms[4 * t + 3].push_back(lost);
  const auto sums = parallel::exact_sums(*context_.group, terms);
  for (std::size_t t = 0; t < tools_->size(); ++t) {
    ToolState tool;
    const Pose pose = pose_at(t, time);
    tool.displacement = pose.displacement;
    tool.position = (*tools_)[t].at + tool.displacement;
    tool.velocity = velocity_at(t, time, nullptr);
    if (pose.orientation) {
      const Eigen::Quaterniond& turn = *pose.orientation;
      tool.orientation = {turn.w(), turn.x(), turn.y(), turn.z()};
      tool.angular_velocity = moving_[t].turning->spin();
    }
    tool.reaction = {sums[4 * t], sums[4 * t + 1], sums[4 * t + 2]};
    tool.friction_work = sums[4 * t + 3];
    for (std::size_t i = 0; i < 3; ++i) state.works.push_back({tool.reaction[i], tool.displacement[i], true});
    state.tools.push_back(tool);
  }
}

std::vector<parallel::NumberedRows> ToolTerm::save() const {
  std::vector<parallel::NumberedRows> tables;
  const auto put = [](parallel::NumberedRows& rows, const auto& values) {
    for (const double value : values) rows.values.push_back(std::bit_cast<std::int64_t>(value));
  };
  for (std::size_t t = 0; t < tools_->size(); ++t) {
    parallel::NumberedRows local;
    local.width = 10;
    for (const Contact& contact : contacts_) {
      if (contact.tool != t || !contact.has_touched()) continue;
      local.numbers.push_back(context_.body->subdomain().layout.number[index(contact.node)]);
      put(local, contact.remainder);
      put(local, std::array{contact.work, contact.taken, contact.held, contact.anchor ? 1.0 : 0.0});
      put(local, contact.anchor.value_or(Vector{}));
    }
    tables.push_back(parallel::gather_rows(*context_.group, local));
  }
  parallel::NumberedRows tools;
  tools.width = 8 + RigidTurning::State{}.size();
  if (context_.group->is_root())
    for (std::size_t t = 0; t < tools_->size(); ++t) {
      tools.numbers.push_back(static_cast<std::int64_t>(t));
      put(tools, moving_[t].displacement);
      put(tools, moving_[t].velocity);
      put(tools, std::array{time_, moving_[t].work});
      put(tools, moving_[t].turning ? moving_[t].turning->state() : RigidTurning::State{});
    }
  tables.push_back(parallel::gather_rows(*context_.group, tools));
  return tables;
}

void ToolTerm::restore(const std::vector<parallel::NumberedRows>& rows) {
  if (rows.size() != tools_->size() + 1)
    throw std::runtime_error("the checkpoint has a different number of tools");
  const auto vector_at = [](std::span<const std::int64_t> row, std::size_t first) {
    Vector vector{};
    for (std::size_t i = 0; i < 3; ++i) vector[i] = std::bit_cast<double>(row[first + i]);
    return vector;
  };
  contacts_.clear();
  for (std::size_t t = 0; t < tools_->size(); ++t) {
    for (std::int32_t n = 0; index(n) < driven_.size(); ++n) {
      const auto row = rows[t].find(context_.body->subdomain().layout.number[index(n)]);
      if (row.empty()) continue;
      Contact contact{.node = n, .tool = t};
      for (std::size_t i = 0; i < 3; ++i) contact.remainder[i] = std::bit_cast<double>(row[i]);
      contact.work = std::bit_cast<double>(row[3]);
      contact.taken = std::bit_cast<double>(row[4]);
      contact.held = std::bit_cast<double>(row[5]);
      if (std::bit_cast<double>(row[6]) != 0) contact.anchor = vector_at(row, 7);
      contacts_.push_back(contact);
    }
    const auto tool = rows.back().find(static_cast<std::int64_t>(t));
    if (tool.empty()) throw std::runtime_error("the checkpoint lacks a tool");
    moving_[t].displacement = vector_at(tool, 0);
    moving_[t].velocity = vector_at(tool, 3);
    time_ = std::bit_cast<double>(tool[6]);
    moving_[t].work = std::bit_cast<double>(tool[7]);
    RigidTurning::State turning;
    for (std::size_t i = 0; i < turning.size(); ++i) turning[i] = std::bit_cast<double>(tool[8 + i]);
    if (moving_[t].turning) moving_[t].turning->restore(turning);
  }
  std::ranges::sort(contacts_, {}, &Contact::place);
  must_find_ = true;
}

MakeTerm make_tools(const std::vector<input::Tool>& tools) {
  const auto at_rest = std::make_shared<std::vector<ToolAtRest>>(tools.size());
  return [&tools, at_rest](const MotionContext& context, const MotionState&, std::int32_t nodes_per_block) {
    return std::make_unique<ToolTerm>(context, tools, *at_rest, nodes_per_block);
  };
}

}  // namespace crackle::dynamics
