// SPDX-License-Identifier: GPL-3.0-or-later
#include "contact_paces.h"

#include "common/index.h"
#include "parallel/agreement.h"
#include "parallel/collectives.h"

#include <algorithm>
#include <bit>
#include <cmath>

namespace crackle::dynamics {

namespace {

/// Steps for which the pairs of a search are to last, at the current speed.
constexpr double steps_per_search = 512;
/// Least and largest margin of a search [spacings].
constexpr double least_margin = 0.02;
constexpr double largest_margin = 0.5;
/// Nodes are fast if they move by more than this share of the farthest movement, and are a smaller share of
/// all than that.
constexpr double share_of_fast = 0.25;
constexpr double largest_share_of_nodes = 1.0 / 256;
/// A margin lasts for at least half as many looks of nodes that become that fast.
constexpr double looks_per_margin = 4;
/// Nodes may move this many times faster from one look to the next than at the look.
constexpr double largest_speedup = 2;

}  // namespace

/// Sets how far nodes move. Collective.
void ContactPaces::find_farthest(std::span<const Vector> movement) {
  std::array<double, 2> farthest{};
  for (std::size_t n = 0; n < index(layout_->n_owned); ++n)
    farthest[is_fast_[n]] = std::max(farthest[is_fast_[n]], dot(movement[n], movement[n]));
  parallel::all_reduce(*group_, farthest, MPI_MAX);
  // The second pace bounds all nodes, for those of a meeting may be of both kinds.
  paces_[0].farthest = std::sqrt(farthest[0]);
  paces_[1].farthest = std::sqrt(std::max(farthest[0], farthest[1]));
}

/// Finds the fast nodes, so that the pairs of all others need not last for their ways. Collective.
void ContactPaces::find_fast(std::span<const Vector> movement) {
  const double limit = share_of_fast * paces_[1].farthest;
  const auto is_fast = [&](std::size_t n) { return dot(movement[n], movement[n]) > limit * limit; };
  std::int64_t n_fast = 0;
  for (std::size_t n = 0; n < index(layout_->n_owned); ++n) n_fast += is_fast(n) ? 1 : 0;
  n_fast = parallel::all_reduce(*group_, n_fast, MPI_SUM);
  const bool are_few =
      static_cast<double>(n_fast) < largest_share_of_nodes * static_cast<double>(layout_->n_global);
  const auto mine = parallel::agree(*group_, [&] {
    std::vector<std::int64_t> numbers;
    for (std::size_t n = 0; are_few && n < index(layout_->n_owned); ++n)
      if (is_fast(n)) numbers.push_back(layout_->number[n]);
    return numbers;
  });
  fast_ = parallel::gather_all<std::int64_t>(*group_, mine);
  std::ranges::sort(fast_);
  mark_fast();
  find_farthest(movement);
}

void ContactPaces::mark_fast() {
  for (std::size_t n = 0; n < is_fast_.size(); ++n) is_fast_[n] = is_fast(layout_->number[n]) ? 1 : 0;
}

bool ContactPaces::is_fast(std::int64_t number) const {
  return std::ranges::binary_search(fast_, number);
}

bool ContactPaces::look(std::span<const Vector> movement, bool is_first, double spacing) {
  find_farthest(movement);
  bool must_search = is_first;
  for (Pace& pace : paces_) {
    pace.moved += steps_per_look * pace.farthest;
    must_search = must_search || 2 * pace.moved >= pace.margin;
  }
  if (must_search) {
    find_fast(movement);
    for (Pace& pace : paces_) pace.moved = 0;
  }
  // Any node may be thrown off and become as fast as the fastest.
  const double next_look = largest_speedup * steps_per_look * paces_[1].farthest;
  for (Pace& pace : paces_) {
    pace.reach = pace.moved + next_look;
    if (must_search)
      pace.margin = std::clamp(std::max(steps_per_search * pace.farthest, looks_per_margin * next_look),
                               least_margin * spacing, largest_margin * spacing);
  }
  return must_search;
}

std::vector<std::int64_t> ContactPaces::words() const {
  std::vector<std::int64_t> words;
  for (const Pace& pace : paces_)
    for (const double value : {pace.margin, pace.moved, pace.reach})
      words.push_back(std::bit_cast<std::int64_t>(value));
  return words;
}

parallel::NumberedRows ContactPaces::fast_nodes() const {
  parallel::NumberedRows rows;
  if (group_->is_root())
    for (const std::int64_t one : fast_) rows.add(one, std::int64_t{1});
  return rows;
}

void ContactPaces::restore(std::span<const std::int64_t> words, const parallel::NumberedRows& fast_nodes) {
  for (std::size_t p = 0; p < paces_.size(); ++p) {
    const auto value = [&](std::size_t k) { return std::bit_cast<double>(words[3 * p + k]); };
    paces_[p] = {value(0), value(1), value(2)};
  }
  fast_ = fast_nodes.numbers;
  mark_fast();
}

}  // namespace crackle::dynamics
