// SPDX-License-Identifier: GPL-3.0-or-later
#include "redraw.h"

#include "common/index.h"

#include <algorithm>
#include <bit>
#include <utility>

namespace crackle::geometry {

namespace {

constexpr int draws_per_attempt = 16;
constexpr int attempts_at_full_amplitude = 3;
constexpr int attempts_until_zero = 16;
constexpr double shrinkage = 0.8;
constexpr int resistance_per_ring = 5;
constexpr int max_rings = 3;
constexpr int resistance_until_reset = 12;
constexpr std::size_t many_cells = 100;

double amplitude_of(int attempt) {
  if (attempt >= attempts_until_zero) return 0;
  double amplitude = 1;
  for (int i = attempts_at_full_amplitude; i < attempt; ++i) amplitude *= shrinkage;
  return amplitude;
}

class Redrawing {
public:
  Redrawing(Tessellation& tessellation, std::span<const std::uint8_t> movable, const Draw& draw,
            RandomStream choice, const RedrawRules& rules)
      : tessellation_(tessellation),
        movable_(movable),
        draw_(draw),
        choice_(choice),
        rules_(rules),
        resistance_(movable.size(), 0),
        attempts_(movable.size(), 0),
        draws_(movable.size(), 0) {}

  RedrawOutcome run() {
    RedrawOutcome outcome;
    std::vector<Tetrahedron> bad = tessellation_.bad_cells();
    std::size_t fewest = bad.size();
    int rounds_in_vain = 0;
    for (; !bad.empty() && outcome.rounds < rules_.max_rounds; ++outcome.rounds) {
      if (bad.size() < fewest - fewest / 10) {
        fewest = bad.size();
        rounds_in_vain = 0;
      } else if (++rounds_in_vain > (bad.size() < many_cells ? rules_.patience : rules_.patience / 10)) {
        break;
      }
      next_.clear();
      n_bad_ = bad.size();
      for (const Tetrahedron& cell : bad) {
        if (!tessellation_.has_bad_cell(cell)) continue;
        treat(cell);
        if (tessellation_.has_bad_cell(cell)) next_.push_back(cell);
      }
      std::sort(next_.begin(), next_.end());
      next_.erase(std::unique(next_.begin(), next_.end()), next_.end());
      std::erase_if(next_, [&](const Tetrahedron& cell) { return !tessellation_.has_bad_cell(cell); });
      bad.swap(next_);
    }
    outcome.remaining = std::move(bad);
    outcome.redrawn_points =
        std::count_if(draws_.begin(), draws_.end(), [](std::int32_t draws) { return draws > 0; });
    return outcome;
  }

private:
  /// Redraws one point of the cell; or of its neighbourhood, if this cell or earlier ones at the same points
  /// have persisted for some time; finally sets growing neighbourhoods to amplitude 0.
  void treat(const Tetrahedron& cell) {
    int resistance = 0;
    for (const std::int32_t node : cell) resistance = std::max(resistance, resistance_[index(node)]++);
    if (rules_.shrinking && !rules_.only_improve && resistance >= resistance_until_reset) {
      for (const std::int32_t node : neighbourhood(cell, resistance - resistance_until_reset)) {
        tessellation_.lift(node);
        tessellation_.put(draw_(node, ++draws_[index(node)], 0), next_);
      }
      return;
    }
    // Rings are for isolated persistent spots, not for meshes where good cells are generally hard to find.
    const int n_rings = n_bad_ < many_cells ? std::min(resistance / resistance_per_ring, max_rings) : 0;
    const std::vector<std::int32_t> pool = neighbourhood(cell, n_rings);
    if (!pool.empty()) redraw(choose(pool));
  }

  /// The movable points of the cell and of some rings around it.
  std::vector<std::int32_t> neighbourhood(const Tetrahedron& cell, int n_rings) const {
    std::vector<std::int32_t> pool(cell.begin(), cell.end());
    for (int ring = 0; ring < n_rings; ++ring) {
      std::vector<std::int32_t> wider = pool;
      for (const std::int32_t node : pool) {
        const std::vector<std::int32_t> neighbours = tessellation_.neighbours(node);
        wider.insert(wider.end(), neighbours.begin(), neighbours.end());
      }
      std::sort(wider.begin(), wider.end());
      wider.erase(std::unique(wider.begin(), wider.end()), wider.end());
      pool.swap(wider);
    }
    std::erase_if(pool, [&](std::int32_t node) { return movable_[index(node)] == 0; });
    return pool;
  }

  /// The point with the fewest attempts so far, preferring points with more freedom.
  std::int32_t choose(const std::vector<std::int32_t>& pool) {
    std::vector<std::int32_t> best;
    int lowest = std::numeric_limits<int>::max();
    for (const std::int32_t node : pool) {
      const int handicap = attempts_[index(node)] + 3 - std::popcount(movable_[index(node)]);
      if (handicap < lowest) best.clear();
      lowest = std::min(lowest, handicap);
      if (handicap == lowest) best.push_back(node);
    }
    return best[index(choice_.bits() % best.size())];
  }

  void redraw(std::int32_t node) {
    const Point before = tessellation_.points()[index(node)];
    const int attempt = attempts_[index(node)]++;
    const double amplitude = rules_.shrinking ? amplitude_of(attempt) : 1;
    tessellation_.lift(node);
    Tessellation::Trial best;
    Point position = before;
    if (rules_.only_improve) best = tessellation_.try_at(before, best);
    for (int i = 0; i < draws_per_attempt; ++i) {
      const Point candidate = draw_(node, ++draws_[index(node)], amplitude);
      const Tessellation::Trial trial = tessellation_.try_at(candidate, best);
      if (trial.better_than(best)) {
        best = trial;
        position = candidate;
      }
      // The first good position is accepted, which preserves the distribution of the draw among good ones.
      if ((best.n_bad == 0 && !(rules_.only_improve && position == before)) || amplitude == 0) break;
    }
    tessellation_.put(position, next_);
  }

  Tessellation& tessellation_;
  std::span<const std::uint8_t> movable_;
  const Draw& draw_;
  RandomStream choice_;
  const RedrawRules& rules_;
  std::vector<int> resistance_;  ///< number of times a bad cell was found at the point
  std::vector<int> attempts_;    ///< number of times the point was redrawn
  std::vector<std::int32_t> draws_;
  std::vector<Tetrahedron> next_;
  std::size_t n_bad_ = 0;  ///< at the start of the round
};

}  // namespace

RedrawOutcome redraw(Tessellation& tessellation, std::span<const std::uint8_t> movable, const Draw& draw,
                     RandomStream choice, const RedrawRules& rules) {
  return Redrawing(tessellation, movable, draw, choice, rules).run();
}

Point displaced(const Body& body, const Point& centre, PlaceId place, double radius, RandomStream stream) {
  const Directions directions = body.directions(place);
  if (directions.n == 0 || radius == 0) return centre;
  // The centre is in the body, so at least an eighth of the ball is too: this many draws all fail with
  // probability below 1e-30.
  for (int draw = 0; draw < 1000; ++draw) {
    Point p = centre;
    double squared = 0;
    for (int k = 0; k < directions.n; ++k) {
      const double offset = stream.uniform(-1, 1);
      squared += offset * offset;
      p = p + radius * offset * directions.vector[index(k)];
    }
    if (squared <= 1 && body.place_of(p) == place) return p;
  }
  return centre;
}

}  // namespace crackle::geometry
