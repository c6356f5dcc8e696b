// SPDX-License-Identifier: GPL-3.0-or-later
#include "crackle/fracture/crack_vicinity.h"

#include "crackle/common/index.h"
#include "crackle/fracture/toughness.h"
#include "crackle/geometry/point.h"
#include "crackle/mechanics/elasticity.h"
#include "crackle/parallel/agreement.h"
#include "crackle/parallel/collectives.h"

#include <algorithm>
#include <cmath>

namespace crackle::fracture {

namespace {

/// How far beyond the corners of a slot's end a tetrahedron counts as at the crack, in spacings.
constexpr double reach_in_spacings = 1.5;

struct SlotTip {
  plane::Point place;  // y and z [m]
  double half_height;  // [m]
};

/// The square ends of slots. An open end is included: nothing is loaded there.
std::vector<SlotTip> square_ends(const input::Specimen& specimen) {
  std::vector<SlotTip> tips;
  for (const input::Notch& notch : specimen.notches) {
    if (notch.slot) {
      if (notch.slot->end == input::SlotEnd::round) continue;
      tips.push_back({notch.slot->from, notch.height / 2});
      tips.push_back({notch.slot->to, notch.height / 2});
      continue;
    }
    const int depth_axis = input::axis_of(notch.face);
    plane::Point tip{};
    tip[index(input::position_axis(notch.face) - 1)] = notch.at;
    tip[index(depth_axis - 1)] =
        input::is_upper(notch.face) ? specimen.size[index(depth_axis)] - notch.depth : notch.depth;
    tips.push_back({tip, notch.height / 2});
  }
  return tips;
}

}  // namespace

CrackVicinity::CrackVicinity(const BreakableBody& body, Criterion& criterion, StressAverage* average,
                             std::vector<double> growth_strengths, const input::Specimen& specimen,
                             std::span<const double> spacings)
    : body_(&body),
      criterion_(&criterion),
      average_(average),
      growth_strengths_(std::move(growth_strengths)),
      round_node_(mechanics::node_tetrahedra(body.subdomain())),
      at_crack_(body.subdomain().nodes.size(), 0) {
  const auto& subdomain = body.subdomain();
  for (std::int32_t node = 0; node < subdomain.n_local(); ++node)
    local_node_[subdomain.layout.number[index(node)]] = node;
  const auto tips = square_ends(specimen);
  for (std::int32_t t = 0; t < subdomain.n_tetrahedra(); ++t) {
    const auto middle = geometry::centroid(subdomain.nodes, subdomain.tetrahedra[index(t)]);
    const bool is_at_tip = std::ranges::any_of(tips, [&](const SlotTip& tip) {
      return std::hypot(middle[1] - tip.place[0], middle[2] - tip.place[1]) <=
             tip.half_height + reach_in_spacings * spacings[index(t)];
    });
    if (is_at_tip) lower(t);
  }
  changed_.clear();
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
    const auto node = local_node_.find(number);
    if (node == local_node_.end() || at_crack_[index(node->second)] != 0) continue;
    at_crack_[index(node->second)] = 1;
    for (const auto t : round_node_[node->second]) lower(t);
  }
  std::ranges::sort(changed_);
  if (average_ != nullptr) average_->forget(changed_);
  return changed_;
}

std::unique_ptr<CrackVicinity> make_crack_vicinity(const parallel::Communicator& group,
                                                   const input::Parameters& parameters, std::uint64_t sample,
                                                   const BreakableBody& body, Criterion& criterion,
                                                   StressAverage* average) {
  if (!parameters.fracture_of(0).separates_nucleation()) return nullptr;
  auto strengths = growth_strengths(group, parameters, sample, body);
  const auto spacings = local_spacings(group, body.subdomain(), body.operators());
  return parallel::agree(group, [&] {
    return std::make_unique<CrackVicinity>(body, criterion, average, std::move(strengths),
                                           parameters.specimen, spacings);
  });
}

void CrackVicinity::lower(std::int32_t tetrahedron) {
  const auto t = index(tetrahedron);
  if (body_->is_broken(tetrahedron) || !(growth_strengths_[t] < criterion_->strength(t))) return;
  criterion_->set_strength(t, growth_strengths_[t]);
  changed_.push_back(tetrahedron);
}

}  // namespace crackle::fracture
