// SPDX-License-Identifier: GPL-3.0-or-later
#include "fracture/crack_vicinity.h"

#include "common/index.h"
#include "geometry/point.h"
#include "mechanics/elasticity.h"
#include "parallel/collectives.h"

#include <algorithm>
#include <cmath>
#include <utility>

namespace crackle::fracture {

namespace {

/// How far beyond the corners of a slot's end a tetrahedron counts as at the crack, in spacings.
constexpr double reach_in_spacings = 1.5;

bool is_at(const SquareEnd& end, const geometry::Point& place, double spacing) {
  return std::hypot(place[1] - end.place[0], place[2] - end.place[1]) <=
         end.half_height + reach_in_spacings * spacing;
}

/// The local number of a node of the realization, or -1.
std::int32_t local_node(const parallel::NodeLayout& layout, std::int64_t number) {
  const auto begin = layout.number.begin(), ghosts = begin + layout.n_owned;
  for (const auto& [first, last] : {std::pair(begin, ghosts), std::pair(ghosts, layout.number.end())}) {
    const auto place = std::lower_bound(first, last, number);
    if (place != last && *place == number) return static_cast<std::int32_t>(place - begin);
  }
  return -1;
}

}  // namespace

std::vector<SquareEnd> square_ends(const plane::Specimen& specimen) {
  std::vector<SquareEnd> ends;
  for (std::size_t i = 0; i < specimen.notches.size(); ++i) {
    const plane::Notch& notch = specimen.notches[i];
    if (notch.slot) {
      if (notch.slot->end == plane::SlotEnd::round) continue;
      const auto& [from, to, end] = *notch.slot;
      const double length = std::hypot(to[0] - from[0], to[1] - from[1]);
      const plane::Point along{(to[0] - from[0]) / length, (to[1] - from[1]) / length};
      ends.push_back({i, from, {-along[0], -along[1]}, notch.height / 2});
      ends.push_back({i, to, along, notch.height / 2});
      continue;
    }
    const int depth_axis = plane::axis_of(notch.face);
    plane::Point tip{}, ahead{};
    tip[index(plane::position_axis(notch.face) - 1)] = notch.at;
    tip[index(depth_axis - 1)] =
        plane::is_upper(notch.face) ? specimen.size[index(depth_axis)] - notch.depth : notch.depth;
    ahead[index(depth_axis - 1)] = plane::is_upper(notch.face) ? -1 : 1;
    ends.push_back({i, tip, ahead, notch.height / 2});
  }
  return ends;
}

bool is_high(const SquareEnd& end, const geometry::SpacingField& spacing, double thickness) {
  return 2 * end.half_height > highest_end_in_spacings * spacing({thickness / 2, end.place[0], end.place[1]});
}

CrackVicinity::CrackVicinity(const BreakableBody& body, Criterion& criterion, StressAverage* average,
                             std::span<const double> growth_strengths, std::span<const SquareEnd> ends,
                             std::span<const double> spacings, bool by_means)
    : body_(&body),
      criterion_(&criterion),
      average_(average),
      growth_strengths_(growth_strengths),
      round_node_(mechanics::node_tetrahedra(body.subdomain())),
      reached_(body.subdomain().tetrahedra.size(), 0),
      at_crack_(body.subdomain().nodes.size(), 0) {
  if (by_means) means_.emplace(body, round_node_);
  const auto& subdomain = body.subdomain();
  for (std::int32_t t = 0; t < subdomain.n_tetrahedra(); ++t) {
    const auto middle = geometry::centroid(subdomain.nodes, subdomain.tetrahedra[index(t)]);
    if (std::ranges::any_of(ends,
                            [&](const SquareEnd& end) { return is_at(end, middle, spacings[index(t)]); }))
      reach(t);
  }
  for (std::size_t t = 0; t < subdomain.pre_crack.size(); ++t)
    if (subdomain.pre_crack[t] != 0 && subdomain.owned[t] != 0)
      arriving_.push_back({static_cast<std::int32_t>(t), -infinity});
  changed_.clear();
  delays_.reserve(spacings.size());
  for (std::size_t t = 0; t < spacings.size(); ++t) {
    const auto number = static_cast<std::int32_t>(t);
    const double speed =
        mechanics::dilatational_speed(body.elasticity()[number], body.material().density[number]);
    delays_.push_back(spacings[t] / speed);
  }
}

std::span<const std::int32_t> CrackVicinity::update(const parallel::Communicator& group, double phase_time) {
  changed_.clear();
  const auto& subdomain = body_->subdomain();
  // A rank need not hold the broken tetrahedron that touches a node of one that it holds.
  const auto nodes = parallel::gather_found<std::int64_t>(group, [&] {
    std::vector<std::int64_t> found;
    for (const Break& one : body_->breaks().subspan(n_seen_))
      arriving_.push_back({subdomain.local_number(one.tetrahedron), one.phase_time});
    n_seen_ = body_->breaks().size();
    std::erase_if(arriving_, [&](const Arriving& one) {
      if (phase_time - one.broke_at < delays_[index(one.tetrahedron)]) return false;
      for (const auto node : subdomain.tetrahedra[index(one.tetrahedron)])
        if (at_crack_[index(node)] == 0) found.push_back(subdomain.layout.number[index(node)]);
      return true;
    });
    return found;
  });
  for (const auto number : nodes) {
    const auto node = local_node(subdomain.layout, number);
    if (node < 0 || at_crack_[index(node)] != 0) continue;
    at_crack_[index(node)] = 1;
    for (const auto t : round_node_[node]) reach(t);
  }
  std::ranges::sort(changed_);
  if (average_ != nullptr) average_->forget(changed_);
  return changed_;
}

void CrackVicinity::reach(std::int32_t tetrahedron) {
  const auto t = index(tetrahedron);
  reached_[t] = 1;
  if (body_->is_broken(tetrahedron) || growth_strengths_.empty() ||
      growth_strengths_[t] == criterion_->strength(t))
    return;
  criterion_->set_strength(t, growth_strengths_[t]);
  changed_.push_back(tetrahedron);
}

}  // namespace crackle::fracture
