// SPDX-License-Identifier: GPL-3.0-or-later
#include "fracture/stress_average.h"

#include "common/index.h"
#include "common/vector.h"
#include "geometry/face_neighbours.h"
#include "geometry/point.h"

#include <algorithm>
#include <cmath>
#include <tuple>

namespace crackle::fracture {

namespace {

/// Cached balls are dropped when they exceed this number of shares, by tetrahedra or by nodes, per
/// tetrahedron of the subdomain.
constexpr std::size_t kept_shares_per_tetrahedron = 8;
constexpr double cells_per_length = 3;

}  // namespace

StressAverage::StressAverage(const BreakableBody& body, std::span<const double> strengths, double length)
    : body_(&body),
      strengths_(strengths),
      length_(length),
      neighbour_(geometry::face_neighbours(body.subdomain().tetrahedra)),
      reached_by_(strengths.size(), 0),
      place_of_node_(body.subdomain().nodes.size(), -1) {
  const auto& subdomain = body.subdomain();
  centroid_.reserve(subdomain.tetrahedra.size());
  for (const auto& t : subdomain.tetrahedra) centroid_.push_back(geometry::centroid(subdomain.nodes, t));
  find_cells();
}

void StressAverage::find_cells() {
  struct Placed {
    std::array<std::int64_t, 4> cell;  // its place, and the kind
    double from_middle;
    std::int32_t tetrahedron;
  };
  std::vector<Placed> all;
  all.reserve(centroid_.size());
  for (std::size_t t = 0; t < centroid_.size(); ++t) {
    Placed placed{{}, 0, static_cast<std::int32_t>(t)};
    for (std::size_t i = 0; i < 3; ++i) {
      const double place = centroid_[t][i] * (cells_per_length / length_);
      placed.cell[i] = static_cast<std::int64_t>(std::floor(place));
      const double offset = place - std::floor(place) - 0.5;
      placed.from_middle += offset * offset;
    }
    placed.cell[3] = body_->subdomain().kind(placed.tetrahedron);
    all.push_back(placed);
  }
  std::ranges::sort(all, {}, [](const Placed& placed) {
    return std::tuple(placed.cell, placed.from_middle, placed.tetrahedron);
  });
  cell_.resize(all.size());
  in_cell_.reserve(all.size());
  for (std::size_t i = 0; i < all.size(); ++i) {
    if (i == 0 || all[i].cell != all[i - 1].cell) first_.push_back(static_cast<std::int32_t>(i));
    cell_[index(all[i].tetrahedron)] = static_cast<std::int32_t>(first_.size()) - 1;
    in_cell_.push_back(all[i].tetrahedron);
  }
  cell_centre_.assign(first_.size(), -1);
  first_.push_back(static_cast<std::int32_t>(all.size()));
}

std::int32_t StressAverage::centre(std::int32_t tetrahedron) {
  forget_broken();
  const std::int32_t cell = cell_[index(tetrahedron)];
  auto& centre = cell_centre_[index(cell)];
  if (centre < 0) {
    const auto members = std::span(in_cell_).subspan(index(first_[index(cell)]),
                                                     index(first_[index(cell + 1)] - first_[index(cell)]));
    centre = *std::ranges::find_if(members, [&](std::int32_t t) { return !body_->is_broken(t); });
  }
  return centre;
}

template <class Ball, class Find>
const Ball& StressAverage::find_in(Cache<Ball>& cache, std::int32_t centre, const Find& find) {
  forget_broken();
  if (const auto known = cache.of_centre.find(centre); known != cache.of_centre.end()) return known->second;
  if (cache.n_shares > kept_shares_per_tetrahedron * strengths_.size()) cache = {};
  const Ball& found = cache.of_centre.emplace(centre, find()).first->second;
  cache.n_shares += found.size();
  return found;
}

std::span<const StressAverage::Share> StressAverage::ball(std::int32_t centre) {
  return find_in(balls_, centre, [&] { return find_ball(centre); });
}

const StressAverage::NodeShares& StressAverage::node_shares(std::int32_t centre) {
  return find_in(node_shares_, centre, [&] { return find_node_shares(centre); });
}

StressAverage::NodeShares StressAverage::find_node_shares(std::int32_t centre) {
  NodeShares shares;
  for (const auto& [number, weight] : ball(centre)) {
    const auto& t = body_->operators().tetrahedra[index(number)];
    for (std::size_t a = 0; a < 4; ++a) {
      auto& place = place_of_node_[index(t.nodes[a])];
      if (place < 0) {
        place = static_cast<std::int32_t>(shares.nodes.size());
        shares.nodes.push_back(t.nodes[a]);
        shares.gradients.push_back({});
      }
      shares.gradients[index(place)] = shares.gradients[index(place)] + weight * t.gradient[a];
    }
  }
  for (const auto node : shares.nodes) place_of_node_[index(node)] = -1;
  return shares;
}

void StressAverage::forget_broken() {
  const auto broken = body_->broken_tetrahedra();
  if (broken.size() == n_breaks_seen_) return;
  for (const auto t : broken.subspan(n_breaks_seen_)) cell_centre_[index(cell_[index(t)])] = -1;
  forget(broken.subspan(n_breaks_seen_));
  n_breaks_seen_ = broken.size();
}

template <class Ball>
void StressAverage::forget_in(Cache<Ball>& cache, std::span<const std::int32_t> tetrahedra) const {
  std::erase_if(cache.of_centre, [&](const auto& ball) {
    const bool is_hit = std::ranges::any_of(tetrahedra, [&](std::int32_t t) {
      const auto offset = centroid_[index(t)] - centroid_[index(ball.first)];
      return dot(offset, offset) <= length_ * length_;
    });
    if (is_hit) cache.n_shares -= ball.second.size();
    return is_hit;
  });
}

void StressAverage::forget(std::span<const std::int32_t> tetrahedra) {
  forget_in(balls_, tetrahedra);
  forget_in(node_shares_, tetrahedra);
}

std::vector<StressAverage::Share> StressAverage::find_ball(std::int32_t centre) {
  std::vector<Share> ball;
  ++n_searches_;
  double sum = 0;
  const auto kind = [&](std::int32_t t) { return body_->subdomain().kind(t); };
  const auto reach = [&](std::int32_t t) {
    if (t < 0 || reached_by_[index(t)] == n_searches_) return;
    reached_by_[index(t)] = n_searches_;
    if (kind(t) != kind(centre)) return;
    const auto offset = centroid_[index(t)] - centroid_[index(centre)];
    const double rest = 1 - dot(offset, offset) / (length_ * length_);
    if (rest <= 0) return;
    const double weight = body_->operators().tetrahedra[index(t)].volume * rest * rest;
    sum += weight;
    if (!body_->is_broken(t)) ball.push_back({t, weight});
  };
  reach(centre);
  for (std::size_t i = 0; i < ball.size(); ++i)
    for (const auto t : neighbour_[index(ball[i].tetrahedron)]) reach(t);
  for (auto& [t, weight] : ball) weight /= sum * strengths_[index(t)];
  return ball;
}

}  // namespace crackle::fracture
