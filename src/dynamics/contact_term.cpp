// SPDX-License-Identifier: GPL-3.0-or-later
#include "contact_term.h"

#include "common/index.h"
#include "dynamics/contact_at_rest.h"
#include "parallel/agreement.h"
#include "parallel/collectives.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <iterator>
#include <stdexcept>
#include <utility>

namespace crackle::dynamics {

namespace {

/// A cut that is open by a strain of this, and by this many times its change from look to look, rests until
/// the next look.
constexpr double least_at_rest = 0.01;
constexpr double changes_at_rest = 4;
/// A node keeps its face up to this far beyond the edges, see found_beyond.
constexpr double kept_beyond = 0.1;
/// Springs act from both sides of a contact, and pull on nodes of both: with this share of what a node's mass
/// allows, all together raise no squared frequency by more than that.
constexpr double springs_of_contact = 4;

std::int64_t as_word(double value) {
  return std::bit_cast<std::int64_t>(value);
}

double as_number(std::int64_t word) {
  return std::bit_cast<double>(word);
}

}  // namespace

ContactTerm::ContactTerm(const MotionContext& context)
    : context_(context),
      scale_(context.contact),
      cuts_acted_before_(context.body->residual_stiffness().contacts_act()),
      dissipated_(index(context.body->subdomain().layout.n_owned), 0.0),
      work_(context.body->subdomain().nodes.size()),
      paces_(*context.group, context.body->subdomain().layout, work_.size()) {}

ContactTerm::~ContactTerm() {
  context_.body->residual_stiffness().let_contacts_act(cuts_acted_before_);
}

void ContactTerm::start(double, const MotionState& state) {
  mechanics::ResidualStiffness& stiffness = context_.body->residual_stiffness();
  stiffness.let_contacts_act(true);
  const auto u = state.displacement.local();
  for (std::size_t i = 0; i < stiffness.contacts().size(); ++i) {
    const std::int32_t t = stiffness.contacts()[i];
    const auto& corners = stiffness.cut_contact(i).corners;
    std::array<Vector, 4> displacement{};
    bool has_moved = false;
    for (std::size_t a = 0; a < 4; ++a)
      for (std::size_t k = 0; k < 3; ++k) {
        displacement[a][k] = u[index(corners[a], k)];
        has_moved = has_moved || displacement[a][k] != 0;
      }
    mechanics::CutContact& cut = stiffness.cut_contact(i);
    if (cuts_acted_before_) {  // they go on from the equilibrium
      cut.dissipated = cut.opening_before = 0;
      cut.rests = false;
    } else {
      stiffness.start_contact(i, has_moved ? cut_strain(i, displacement) : mechanics::Symmetric{});
    }
    cut.is_apart = is_apart(t, displacement);
  }
  stiffness.find_acting();
}

mechanics::Symmetric ContactTerm::cut_strain(std::size_t i, const std::array<Vector, 4>& displacement) const {
  const auto& stiffness = std::as_const(*context_.body).residual_stiffness();
  return context_.body->initial_strain().elastic(stiffness.contacts()[i],
                                                 stiffness.cut_contact(i).strain(displacement));
}

bool ContactTerm::is_apart(std::int32_t tetrahedron, const std::array<Vector, 4>& displacement) const {
  const geometry::Subdomain& part = context_.body->subdomain();
  double longest = 0, farthest = 0;
  for (std::size_t a = 0; a < 4; ++a)
    for (std::size_t b = 0; b < a; ++b) {
      const auto& corners = part.tetrahedra[index(tetrahedron)];
      longest = std::max(longest, norm(part.nodes[index(corners[a])] - part.nodes[index(corners[b])]));
      farthest = std::max(farthest, norm(displacement[a] - displacement[b]));
    }
  return farthest > longest;
}

void ContactTerm::settle_cuts(const MovingNodes& nodes) {
  mechanics::ResidualStiffness& stiffness = context_.body->residual_stiffness();
  const bool has_initial_strain = !context_.body->initial_strain().is_none();
  const auto displacements = [&](std::size_t i) {
    std::array<Vector, 4> displacement{};
    for (std::size_t a = 0; a < 4; ++a)
      displacement[a] = nodes.whole_displacement(stiffness.cut_contact(i).corners[a]);
    return displacement;
  };
  if (n_steps_ % ContactPaces::steps_per_look != 0) {
    for (const std::int32_t i : stiffness.acting())
      // One that is open needs no friction, even if it closes before the next look.
      if (!stiffness.cut_contact(index(i)).is_open)
        stiffness.settle_contact(index(i), cut_strain(index(i), displacements(index(i))));
    return;
  }
  for (std::size_t i = 0; i < stiffness.contacts().size(); ++i) {
    mechanics::CutContact& cut = stiffness.cut_contact(i);
    if (cut.is_apart) continue;
    const std::int32_t t = stiffness.contacts()[i];
    const std::array<Vector, 4> displacement = displacements(i);
    const double opening = cut.opening(displacement);
    // Where sides meet at rest, by a violent motion, their faces' contact takes over.
    if (cut.rests && opening < mechanics::surely_open) {
      cut.is_apart = true;
      cut.rests = false;
      continue;
    }
    if (!cut.is_open || has_initial_strain || opening < mechanics::surely_open)
      stiffness.settle_contact(i, cut_strain(i, displacement));
    if (cut.is_open) cut.is_apart = is_apart(t, displacement);
    cut.rests = scale_.rate > 0 && cut.is_open && !has_initial_strain &&
                opening > least_at_rest + changes_at_rest * std::abs(opening - cut.opening_before);
    cut.opening_before = opening;
  }
  stiffness.find_acting();
}

bool ContactTerm::is_mine(const Meeting& meeting) const {
  const std::int32_t node = corners_[meeting.node].local;
  return node >= 0 && node < context_.body->subdomain().layout.n_owned;
}

std::vector<ContactTerm::Node> ContactTerm::own_nodes() const {
  const parallel::NodeLayout& layout = context_.body->subdomain().layout;
  std::vector<std::int64_t> numbers;
  for (const ContactPair& pair : pairs_) {
    numbers.push_back(pair.node);
    numbers.insert(numbers.end(), pair.corners.begin(), pair.corners.end());
  }
  std::ranges::sort(numbers);
  numbers.erase(std::unique(numbers.begin(), numbers.end()), numbers.end());
  std::vector<Node> nodes;
  const auto owned = std::span(layout.number).first(index(layout.n_owned));
  for (const std::int64_t one : numbers) {
    const auto place = std::ranges::lower_bound(owned, one);
    if (place == owned.end() || *place != one) continue;
    const auto n = static_cast<std::int32_t>(place - owned.begin());
    const auto contact = known_.find(one);
    nodes.push_back({one,
                     {static_cast<std::int32_t>(context_.group->rank()), n},
                     context_.body->subdomain().nodes[index(n)],
                     context_.body->operators().node_mass[index(n)],
                     contact == known_.end() ? Contact{} : contact->second});
  }
  return nodes;
}

/// Adds that of a node with its candidates. What it had stored with a face that has broken, or is out of
/// reach, is lost.
/// @param node_of, place_of the node with a number, and its place in corners_
void ContactTerm::add_meeting(std::span<const ContactPair> pairs, const auto& node_of, const auto& place_of) {
  const Node& node = node_of(pairs.front().node);
  Meeting& meeting = meetings_.emplace_back();
  meeting.node = place_of(node.number);
  meeting.is_fast = paces_.is_fast(node.number);
  meeting.contact = node.contact;
  meeting.first = candidates_.size();
  const auto gap = known_gaps_.find(node.number);
  meeting.gap = gap == known_gaps_.end() ? std::ranges::min(pairs, {}, &ContactPair::gap).gap : gap->second;
  bool is_kept = false;
  for (const ContactPair& pair : pairs) {
    if (pair.face == node.contact.face) {
      is_kept = true;
      meeting.candidate = candidates_.size();
    }
    Candidate candidate{pair.face, {}, pair.open, pair.depth, 0};
    double lightest = node.mass;
    for (std::size_t a = 0; a < 4; ++a) {
      candidate.corners[a] = place_of(pair.corners[a]);
      if (a == 3) continue;
      lightest = std::min(lightest, node_of(pair.corners[a]).mass);
      meeting.meets_fast = meeting.meets_fast || paces_.is_fast(pair.corners[a]);
    }
    candidate.stiffness = scale_.rate * lightest / springs_of_contact;
    candidates_.push_back(candidate);
  }
  meeting.last = candidates_.size();
  if (is_kept) return;
  if (is_mine(meeting)) dissipated_[index(node.source.node)] += meeting.contact.energy;
  meeting.contact = {};
}

/// Finds the nodes of the pairs that concern this rank, and how their positions get here. Collective.
void ContactTerm::connect() {
  const parallel::Communicator& group = *context_.group;
  const parallel::NodeLayout& layout = context_.body->subdomain().layout;
  is_connected_ = false;
  exchange_.reset();
  const auto mine = parallel::agree(group, [&] { return own_nodes(); });
  auto all = parallel::gather_all<Node>(group, mine);
  parallel::NodeLayout received;
  received.n_global = layout.n_global;
  received.n_owned = layout.n_owned;
  parallel::agree(group, [&] {
    std::ranges::sort(all, {}, &Node::number);
    const auto node_of = [&](std::int64_t one) -> const Node& {
      return *std::ranges::lower_bound(all, one, {}, &Node::number);
    };
    const auto is_owned = [&](std::int64_t one) { return node_of(one).source.rank == group.rank(); };
    const auto ghosts = std::span(layout.number).subspan(index(layout.n_owned));
    std::unordered_map<std::int64_t, std::size_t> places;
    corners_.clear();
    candidates_.clear();
    meetings_.clear();
    received.number.assign(layout.number.begin(), layout.number.begin() + layout.n_owned);
    const auto place_of = [&](std::int64_t one) {
      const auto [place, is_new] = places.try_emplace(one, corners_.size());
      if (!is_new) return place->second;
      const Node& node = node_of(one);
      Corner corner{one, -1, 0, node.at_start};
      if (is_owned(one)) {
        corner.local = node.source.node;
      } else if (const auto ghost = std::ranges::lower_bound(ghosts, one);
                 ghost != ghosts.end() && *ghost == one) {
        corner.local = static_cast<std::int32_t>(layout.n_owned + (ghost - ghosts.begin()));
      } else {
        corner.received = received.ghosts.size();
        received.ghosts.push_back(node.source);
        received.number.push_back(one);
      }
      corners_.push_back(corner);
      return corners_.size() - 1;
    };
    for (std::size_t begin = 0, end = 0; begin < pairs_.size(); begin = end) {
      bool concerns = is_owned(pairs_[begin].node);
      for (; end < pairs_.size() && pairs_[end].node == pairs_[begin].node; ++end)
        for (std::size_t a = 0; a < 3; ++a) concerns = concerns || is_owned(pairs_[end].corners[a]);
      if (concerns) add_meeting(std::span(pairs_).subspan(begin, end - begin), node_of, place_of);
    }
    // Also contacts of nodes that have no more pairs.
    for (const auto& [one, contact] : known_)
      if (!std::ranges::binary_search(all, one, {}, &Node::number)) {
        const auto owned = std::span(layout.number).first(index(layout.n_owned));
        dissipated_[index(std::ranges::lower_bound(owned, one) - owned.begin())] += contact.energy;
      }
    known_.clear();
    known_gaps_.clear();
    // As many as there may be, so that later looks need no memory.
    awake_.reserve(meetings_.size());
    awake_corners_.reserve(corners_.size());
    is_awake_.resize(corners_.size());
    find_awake();
  });
  if (group.size() > 1) exchange_.emplace(group, received);
  parallel::check_peers(group);
  is_connected_ = true;
}

/// True if a node has contact, or may get it before the next look.
bool ContactTerm::is_awake(const Meeting& meeting) const {
  return meeting.contact.face >= 0 ||
         meeting.gap <= paces_.reach(meeting.is_fast) + paces_.reach(meeting.meets_fast);
}

/// Finds the meetings that are awake, and their nodes.
void ContactTerm::find_awake() {
  awake_.clear();
  awake_corners_.clear();
  std::ranges::fill(is_awake_, std::uint8_t{0});
  const auto wake = [&](std::size_t corner) {
    if (std::exchange(is_awake_[corner], 1) == 0) awake_corners_.push_back(corner);
  };
  for (std::size_t m = 0; m < meetings_.size(); ++m) {
    const Meeting& meeting = meetings_[m];
    if (!is_awake(meeting)) continue;
    awake_.push_back(m);
    wake(meeting.node);
    for (std::size_t c = meeting.first; c < meeting.last; ++c)
      std::ranges::for_each(candidates_[c].corners, wake);
  }
}

/// Between a node and its candidates now [m].
double ContactTerm::gap(const Meeting& meeting) const {
  double least = infinity;
  for (std::size_t c = meeting.first; c < meeting.last; ++c) {
    const Candidate& candidate = candidates_[c];
    std::array<Vector, 3> face{};
    for (std::size_t a = 0; a < 3; ++a) face[a] = corners_[candidate.corners[a]].now;
    const Vector area = cross(face[1] - face[0], face[2] - face[0]);
    const double twice = norm(area);
    const Vector normal = area / (twice > 0 ? twice : 1);
    least = std::min(least, contact_gap(corners_[meeting.node].now, face, normal, candidate.depth));
  }
  return least;
}

/// Measures the gaps again that are too small for the meeting to sleep, as far as is known.
void ContactTerm::find_gaps(const MovingNodes& nodes) {
  find_awake();
  for (const std::size_t corner : awake_corners_) place(corner, nodes);
  for (const std::size_t m : awake_) {
    Meeting& meeting = meetings_[m];
    if (meeting.contact.face < 0)
      meeting.gap = std::max(meeting.gap,
                             gap(meeting) + paces_.moved(meeting.is_fast) + paces_.moved(meeting.meets_fast));
  }
  find_awake();
}

/// Gets the current displacements of nodes of other ranks. Collective.
void ContactTerm::receive(const MovingNodes& nodes) {
  if (!exchange_) return;
  for (std::size_t i = 0; i < exchange_->sent().size(); ++i)
    exchange_->sent()[i] = nodes.whole_displacement(exchange_->sent_nodes()[i]);
  exchange_->begin();
  exchange_->end();
}

void ContactTerm::place(std::size_t number, const MovingNodes& nodes) {
  Corner& corner = corners_[number];
  corner.now = corner.at_start + (corner.local >= 0 ? nodes.whole_displacement(corner.local)
                                                    : exchange_->received()[corner.received]);
}

ContactTerm::Position ContactTerm::position(const Meeting& meeting, const Candidate& candidate) const {
  const auto x = [&](std::size_t a) -> const Vector& { return corners_[candidate.corners[a]].now; };
  const Vector area = cross(x(1) - x(0), x(2) - x(0));
  Position position{{}, norm(area), 0, {}};
  position.normal = area / position.twice;
  const Vector& node = corners_[meeting.node].now;
  position.depth = dot(position.normal, x(0) - node);
  position.weight = weights(candidate, position, node);
  return position;
}

std::array<double, 3> ContactTerm::weights(const Candidate& candidate, const Position& on_face,
                                           const Vector& point) const {
  const auto x = [&](std::size_t a) -> const Vector& { return corners_[candidate.corners[a]].now; };
  std::array<double, 3> weight{};
  for (std::size_t a = 1; a < 3; ++a) {
    const Vector& p = x((a + 1) % 3);
    weight[a] = dot(on_face.normal, cross(x((a + 2) % 3) - p, point - p)) / on_face.twice;
  }
  weight[0] = 1 - weight[1] - weight[2];
  return weight;
}

ContactTerm::Force ContactTerm::force(const Meeting& meeting) const {
  const Contact& contact = meeting.contact;
  const Candidate& candidate = candidates_[meeting.candidate];
  Force force{position(meeting, candidate)};
  const double depth = force.position.depth - contact.offset;
  if (!(depth > 0)) return force;
  force.normal = contact.stiffness * depth;
  force.energy = 0.5 * force.normal * depth;
  if (scale_.friction == 0) return force;
  for (std::size_t a = 0; a < 3; ++a)
    force.slide =
        force.slide + (force.position.weight[a] - contact.stick[a]) * corners_[candidate.corners[a]].now;
  force.tangential = -contact.stiffness * force.slide;
  const double most = scale_.friction * force.normal, size = norm(force.tangential);
  force.slips = size > most;
  if (force.slips) force.tangential = most / size * force.tangential;
  force.energy += 0.5 * dot(force.tangential, force.tangential) / contact.stiffness;
  return force;
}

void ContactTerm::add_forces(MovingNodes& nodes) {
  if (!touches_) return;
  if (!is_connected_) connect();
  receive(nodes);
  for (const std::size_t m : awake_) {
    const Meeting& meeting = meetings_[m];
    if (meeting.contact.face < 0) continue;
    place(meeting.node, nodes);
    for (std::size_t a = 0; a < 3; ++a) place(candidates_[meeting.candidate].corners[a], nodes);
    const Force force = this->force(meeting);
    if (force.normal == 0) continue;
    const Vector on_node = force.normal * force.position.normal + force.tangential;
    const auto owned = [&](std::size_t corner) {
      const std::int32_t local = corners_[corner].local;
      return local < context_.body->subdomain().layout.n_owned ? local : -1;
    };
    std::array<std::int32_t, 4> at{owned(meeting.node)};
    std::array<Vector, 4> forces{};
    for (std::size_t a = 0; a < 3; ++a) {
      at[a + 1] = owned(candidates_[meeting.candidate].corners[a]);
      forces[a + 1] = -force.position.weight[a] * on_node;
    }
    nodes.add_balanced_forces(at, forces);
  }
}

/// True if a node is in front of a face, as most are: found without a square root.
bool ContactTerm::is_in_front(const Meeting& meeting, const Candidate& candidate) const {
  const Vector& x = corners_[candidate.corners[0]].now;
  const Vector area = cross(corners_[candidate.corners[1]].now - x, corners_[candidate.corners[2]].now - x);
  return dot(area, x - corners_[meeting.node].now) <= 0;
}

/// True if a node is below a face, within the face's edges, and not beyond another face of the surface.
bool ContactTerm::is_below(const Meeting& meeting, const Candidate& candidate,
                           const Position& position) const {
  if (!(position.depth > 0 && position.depth < candidate.depth)) return false;
  if (!(std::ranges::min(position.weight) >= -found_beyond)) return false;
  for (std::size_t a = 0; a < 3; ++a) {
    if (((candidate.open >> a) & 1) == 0) continue;
    const Vector& apex = corners_[candidate.corners[3]].now;
    const Vector& p = corners_[candidate.corners[(a + 1) % 3]].now;
    const Vector& q = corners_[candidate.corners[(a + 2) % 3]].now;
    const Vector area = cross(q - p, apex - p);
    const Vector& corner = corners_[candidate.corners[a]].now;
    if (dot(area, corners_[meeting.node].now - p) / dot(area, corner - p) < -found_beyond) return false;
  }
  return true;
}

/// Lets a node find its face, and slip.
void ContactTerm::settle(Meeting& meeting) {
  Contact& contact = meeting.contact;
  const Contact before = contact;
  double energy_before = 0, slipped = 0;
  bool may_keep = false;
  if (contact.face >= 0) {
    const Candidate& candidate = candidates_[meeting.candidate];
    const Force force = this->force(meeting);
    energy_before = force.energy;
    if (scale_.friction > 0) {
      const double size = norm(force.tangential);
      if (force.slips) {
        const double share = size / (contact.stiffness * norm(force.slide));
        slipped = 0.5 * (contact.friction + size) * (1 - share) * norm(force.slide);
        for (std::size_t a = 0; a < 3; ++a)
          contact.stick[a] = force.position.weight[a] - share * (force.position.weight[a] - contact.stick[a]);
      }
      contact.friction = size;
    }
    contact.energy = force.energy;
    const bool is_near = force.position.depth > 0 && std::ranges::min(force.position.weight) >= -kept_beyond;
    if (!is_below(meeting, candidate, force.position)) {
      may_keep = is_near;  // if there is no other
      contact.face = -1;
    }
  }
  if (contact.face < 0) {
    std::size_t best = 0;
    std::optional<Position> found;
    for (std::size_t c = meeting.first; c < meeting.last; ++c) {
      if (is_in_front(meeting, candidates_[c])) continue;
      const Position position = this->position(meeting, candidates_[c]);
      if (!is_below(meeting, candidates_[c], position)) continue;
      if (found && found->depth <= position.depth) continue;
      found = position;
      best = c;
    }
    if (found) {
      const Candidate& candidate = candidates_[best];
      Contact next{candidate.face, candidate.stiffness, found->depth, found->weight};
      if (before.face >= 0) {
        // The node moves on to the next face with its energy.
        const double share = std::sqrt(before.stiffness / candidate.stiffness);
        const Force old = force(meeting);
        const double depth = std::max(old.position.depth - before.offset, 0.0);
        next.offset -= share * depth;
        if (depth > 0) {
          const Vector slide = share / before.stiffness * old.tangential;
          // The point where it sticks, in the plane of the next face.
          next.stick = weights(candidate, *found, corners_[meeting.node].now + slide);
        }
      }
      meeting.candidate = best;
      contact = next;
      const Force force = this->force(meeting);
      contact.friction = norm(force.tangential);
      contact.energy = force.energy;
    } else if (may_keep) {
      contact.face = before.face;
    } else {
      contact = {};
    }
  }
  if (is_mine(meeting))
    // The work of friction, and the energy lost with a face.
    dissipated_[index(corners_[meeting.node].local)] += slipped + (energy_before - contact.energy);
}

void ContactTerm::end_step(const mechanics::StepSpan&, MovingNodes& nodes, const Drives&) {
  settle_cuts(nodes);
  ++n_steps_;
  if (scale_.rate == 0) return;
  if (!pairs_.empty()) {
    if (!is_connected_) connect();
    receive(nodes);
    for (const std::size_t corner : awake_corners_) place(corner, nodes);
    bool touches = false;
    for (const std::size_t m : awake_) {
      if (is_awake(meetings_[m])) settle(meetings_[m]);
      touches = touches || meetings_[m].contact.face >= 0;
    }
    touches_ = parallel::any_of_all(*context_.group, touches);
  }
  if (n_steps_ % ContactPaces::steps_per_look == 1) search(nodes);
}

/// Finds the pairs again if nodes have moved so far that others may meet. Collective.
void ContactTerm::search(MovingNodes& nodes) {
  const parallel::Communicator& group = *context_.group;
  nodes.movements(work_);
  if (!paces_.look(work_, n_steps_ == 1, scale_.spacing)) {
    find_gaps(nodes);
    return;
  }
  for (std::size_t n = 0; n < work_.size(); ++n)
    work_[n] = nodes.whole_displacement(static_cast<std::int32_t>(n));
  parallel::agree(group, [&] {
    for (const Meeting& meeting : meetings_)
      if (meeting.contact.face >= 0 && is_mine(meeting))
        known_.emplace(corners_[meeting.node].number, meeting.contact);
  });
  pairs_ = find_contact_pairs(group, *context_.body, work_, paces_.margins());
  connect();
  touches_ = touches_ && !pairs_.empty();
}

void ContactTerm::add_dissipated(std::vector<double>& sum) const {
  sum.insert(sum.end(), dissipated_.begin(), dissipated_.end());
  const auto& stiffness = std::as_const(*context_.body).residual_stiffness();
  for (std::size_t i = 0; i < stiffness.contacts().size(); ++i)
    if (context_.body->subdomain().owned[index(stiffness.contacts()[i])] != 0)
      sum.push_back(stiffness.cut_contact(i).dissipated);
}

void ContactTerm::add_stored(const parallel::NodeField&, std::vector<double>& sum) const {
  for (const Meeting& meeting : meetings_)
    if (is_mine(meeting)) sum.push_back(meeting.contact.energy);
}

void ContactTerm::add_lost_at_rest(const parallel::NodeField& displacement, std::vector<double>& sum) const {
  add_stored(displacement, sum);  // cuts stay closed
}

std::vector<parallel::NumberedRows> ContactTerm::save() const {
  const parallel::Communicator& group = *context_.group;
  const geometry::Subdomain& part = context_.body->subdomain();
  parallel::NumberedRows course, pairs, contacts, dissipated, gaps;
  parallel::NumberedRows fast = paces_.fast_nodes();
  course.width = 1 + ContactPaces::n_words;
  pairs.width = 9;
  contacts.width = 8;
  if (group.is_root()) {
    course.numbers = {0};
    course.values = {n_steps_};
    std::ranges::copy(paces_.words(), std::back_inserter(course.values));
    for (const auto& [one, gap] : known_gaps_) gaps.add(one, gap);
    for (std::size_t p = 0; p < pairs_.size(); ++p) {
      const ContactPair& pair = pairs_[p];
      pairs.numbers.push_back(static_cast<std::int64_t>(p));
      pairs.values.insert(pairs.values.end(),
                          {pair.node, pair.face, pair.corners[0], pair.corners[1], pair.corners[2],
                           pair.corners[3], pair.open, as_word(pair.depth), as_word(pair.gap)});
    }
  }
  const auto add = [&](std::int64_t one, const Contact& contact) {
    contacts.numbers.push_back(one);
    contacts.values.insert(contacts.values.end(),
                           {contact.face, as_word(contact.stiffness), as_word(contact.offset),
                            as_word(contact.stick[0]), as_word(contact.stick[1]), as_word(contact.stick[2]),
                            as_word(contact.friction), as_word(contact.energy)});
  };
  for (const Meeting& meeting : meetings_) {
    if (!is_mine(meeting)) continue;
    gaps.add(corners_[meeting.node].number, meeting.gap);
    if (meeting.contact.face >= 0) add(corners_[meeting.node].number, meeting.contact);
  }
  for (const auto& [one, contact] : known_) add(one, contact);
  for (std::size_t n = 0; n < dissipated_.size(); ++n)
    if (dissipated_[n] != 0) dissipated.add(part.layout.number[n], dissipated_[n]);
  std::vector<parallel::NumberedRows> rows;
  for (const parallel::NumberedRows* const table : {&course, &pairs, &contacts, &dissipated, &gaps, &fast})
    rows.push_back(parallel::gather_rows(group, *table));
  rows.push_back(save_cuts(group, *context_.body));
  return rows;
}

void ContactTerm::restore(const std::vector<parallel::NumberedRows>& rows) {
  const geometry::Subdomain& part = context_.body->subdomain();
  if (rows.size() != 7 || rows[0].values.size() != 1 + ContactPaces::n_words)
    throw std::runtime_error("the checkpoint has another kind of contact");
  n_steps_ = rows[0].values[0];
  paces_.restore(std::span(rows[0].values).subspan(1), rows[5]);
  pairs_.clear();
  for (std::size_t p = 0; p < rows[1].numbers.size(); ++p) {
    const auto v = std::span(rows[1].values).subspan(9 * p, 9);
    pairs_.push_back({v[0], v[1], {v[2], v[3], v[4], v[5]}, v[6], as_number(v[7]), as_number(v[8])});
  }
  known_.clear();
  known_gaps_.clear();
  for (const std::int64_t one : rows[4].numbers) known_gaps_.emplace(one, rows[4].number_at(one));
  is_connected_ = false;
  touches_ = !pairs_.empty();
  for (std::size_t n = 0; n < dissipated_.size(); ++n) {
    const std::int64_t one = part.layout.number[n];
    dissipated_[n] = rows[3].number_at(one);
    const auto v = rows[2].find(one);
    if (!v.empty())
      known_.emplace(one, Contact{v[0],
                                  as_number(v[1]),
                                  as_number(v[2]),
                                  {as_number(v[3]), as_number(v[4]), as_number(v[5])},
                                  as_number(v[6]),
                                  as_number(v[7])});
  }
  restore_cuts(rows[6], *context_.body);
}

}  // namespace crackle::dynamics
