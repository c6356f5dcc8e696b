// SPDX-License-Identifier: GPL-3.0-or-later
#include "blue_noise.h"

#include "common/index.h"
#include "common/vector.h"

#include "near_pairs.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <span>
#include <utility>

namespace crackle::geometry {

namespace {

/// Lengths in local spacings.
constexpr double reach_inside = 1.35;
constexpr double reach_in_face = 1.2;
constexpr double skin = 0.3;  ///< pairs are listed up to here beyond the reach
constexpr double longest_step = 0.15;
constexpr double mobility = 0.067;  ///< step for a force of one spacing squared
constexpr double momentum = 0.8;    ///< share of a step that is repeated by the next one
constexpr double last_shift = 0.1;  ///< largest last random displacement along each axis

/// Fixed points repel less, or else the others would keep too far away from surfaces and edges.
constexpr double force_of_fixed = 0.85;

/// Numbers of steps with the same list of pairs: few at first, when random points move far. Points that
/// approach each other unlisted would end as close pairs.
constexpr std::array<int, 5> n_steps{3, 4, 6, 7, 8};

/// Fewer points than these are moved faster alone than together.
constexpr std::size_t few_points = 2000;

/// The pairs of a batch that are within reach.
struct NearPair {
  Vector gap;
  std::int32_t other;
};
struct NearBatch {
  static constexpr std::size_t few = 512;  ///< pairs, which the cache holds

  std::size_t n = 0;
  std::vector<NearPair> pairs;  ///< these lists are longer
  std::vector<double> range, squared, factor;

  void make_room(std::size_t n_more) {
    if (pairs.size() >= n + n_more) return;
    const std::size_t size = std::max(2 * few, n + n_more);
    pairs.resize(size);
    for (auto* each : {&range, &squared, &factor}) each->resize(size);
  }
};

class Relaxation {
public:
  Relaxation(const SpacingField& spacing, const Patch& patch, const Room& room, const SpacedPoints& fixed,
             const SpacedPoints& points, Crew* crew)
      : spacing_(spacing),
        patch_(patch),
        room_(room),
        crew_(points.position.size() < few_points ? nullptr : crew),
        n_(points.position.size()) {
    const std::size_t n_all = n_ + fixed.position.size();
    place_.reserve(n_all);
    local_.reserve(n_all);
    for (const SpacedPoints* each : {&points, &fixed}) {
      for (const Point& p : each->position) place_.push_back(own(p));
      local_.insert(local_.end(), each->spacing.begin(), each->spacing.end());
    }
    velocity_.assign(n_, Vector{});
    headroom_.assign(n_, 0);
    force_.resize(n_all);
    // Fixed points have about half as many pairs.
    const std::size_t n_workers = crew_ ? crew_->size() : 1;
    for (std::size_t worker = 0; worker <= n_workers; ++worker) {
      const std::size_t share = (n_ + n_all) * worker / n_workers;
      const std::size_t first = share <= 2 * n_ ? share / 2 : share - n_;
      first_of_.push_back(std::min(first, n_));
      if (!crew_ || worker == crew_->rank()) begin_ = first;
      if (crew_ && worker == crew_->rank() + 1) end_ = first;
    }
    if (!crew_) begin_ = 0, end_ = n_all;
    movable_end_ = std::min(end_, n_);
  }

  void run() {
    const double reach = is_flat(patch_.domain) ? reach_in_face : reach_inside;
    std::vector<double> radius(place_.size());
    for (const int n : n_steps) {
      for (std::size_t i = 0; i < place_.size(); ++i) radius[i] = (reach + skin) * local_[i];
      const NearPairs pairs = near_pairs(place_, radius, n_, begin_, end_);
      exchange_pairs(pairs);
      for (int step = 0; step < n; ++step) {
        sum_forces(pairs, reach);
        for (std::size_t i = begin_; i < movable_end_; ++i) move(i);
        share_places();
      }
      update_spacing();
    }
  }

  /// Takes away the order of a dense fluid, whose layers along faces would favour directions of cracks.
  void shake(RandomStream& stream) {
    for (std::size_t i = 0; i < n_; ++i) {
      Vector shift{};
      for (std::size_t axis = 0; axis < 3; ++axis)
        if (patch_.domain.upper[axis] > patch_.domain.lower[axis])
          shift[axis] = stream.uniform(-last_shift, last_shift) * local_[i];
      if (is_own(i) && has_room(i, place_[i] + shift)) place_[i] = place_[i] + shift;
    }
    share_places();
    update_spacing();
  }

  SpacedPoints result() const {
    SpacedPoints points;
    for (std::size_t i = 0; i < n_; ++i) points.position.push_back(patch_.at(place_[i]));
    points.spacing.assign(local_.begin(), local_.begin() + static_cast<std::ptrdiff_t>(n_));
    return points;
  }

private:
  using Pair = std::array<std::int32_t, 2>;

  /// Own coordinates, exactly in the patch.
  Point own(const Point& p) const {
    Point result = patch_.own(p);
    for (std::size_t i = 0; i < 3; ++i)
      if (patch_.domain.lower[i] == patch_.domain.upper[i]) result[i] = patch_.domain.lower[i];
    return result;
  }

  bool is_own(std::size_t i) const { return begin_ <= i && i < end_; }

  void share_places() {
    if (!crew_) return;
    std::vector<std::size_t> first = first_of_;
    for (std::size_t& each : first) each *= 3;
    crew_->share({place_.data()->data(), 3 * n_}, first);
  }

  void update_spacing() {
    for (std::size_t i = begin_; i < movable_end_; ++i) local_[i] = spacing_(patch_.at(place_[i]));
    if (crew_) crew_->share({local_.data(), n_}, first_of_);
  }

  /// Finds the pairs of own points that others list.
  void exchange_pairs(const NearPairs& pairs) {
    if (!crew_) return;
    std::vector<Pair> listed;
    for (std::size_t i = begin_; i < end_; ++i)
      for (std::size_t k = pairs.first[i - begin_]; k < pairs.first[i - begin_ + 1]; ++k)
        if (const std::int32_t j = pairs.other[k]; index(j) < n_ && !is_own(index(j)))
          listed.push_back({static_cast<std::int32_t>(i), j});
    before_.clear();
    after_.clear();
    for (const Pair& pair : crew_->gather(listed))
      if (is_own(index(pair[1]))) (index(pair[0]) < begin_ ? before_ : after_).push_back(pair);
  }

  /// Sums the forces on own points; those on others are not complete. The order of the sum is that of the
  /// points that list the pairs, whoever computes it.
  void sum_forces(const NearPairs& pairs, double reach) {
    const auto begin = force_.begin();
    std::fill(begin + static_cast<std::ptrdiff_t>(begin_), begin + static_cast<std::ptrdiff_t>(end_),
              Vector{});
    add_listed_by_others(before_, reach);
    for (std::size_t i = begin_; i < end_;) i = add_batch(pairs, i, reach);
    add_listed_by_others(after_, reach);
  }

  /// Adds the forces of the pairs that points from `first` on list. @return the first of the next batch
  std::size_t add_batch(const NearPairs& pairs, std::size_t first, double reach) {
    const std::size_t* const list = &pairs.first[first - begin_];
    std::array<std::size_t, NearBatch::few> n_until{};
    std::size_t n_points = 0;
    batch_.n = 0;
    while (first + n_points < end_ && n_points < n_until.size() && batch_.n < NearBatch::few) {
      batch_.make_room(list[n_points + 1] - list[n_points]);
      consider(first + n_points,
               std::span(pairs.other).subspan(list[n_points], list[n_points + 1] - list[n_points]), reach);
      n_until[n_points++] = batch_.n;
    }
    compute_factors();
    std::size_t k = 0;
    for (std::size_t i = 0; i < n_points; ++i) {
      Vector sum = force_[first + i];
      for (; k < n_until[i]; ++k) {
        const Vector force = batch_.factor[k] * batch_.pairs[k].gap;
        Vector& opposite = force_[index(batch_.pairs[k].other)];
        sum = sum + force;
        opposite = opposite - force;
      }
      force_[first + i] = sum;
    }
    return first + n_points;
  }

  void add_listed_by_others(std::span<const Pair> pairs, double reach) {
    for (std::size_t begin = 0; begin < pairs.size(); begin += NearBatch::few) {
      const auto part = pairs.subspan(begin, std::min(NearBatch::few, pairs.size() - begin));
      batch_.n = 0;
      batch_.make_room(part.size());
      for (const Pair& pair : part) consider(index(pair[0]), {&pair[1], 1}, reach);
      compute_factors();
      for (std::size_t k = 0; k < batch_.n; ++k) {
        Vector& opposite = force_[index(batch_.pairs[k].other)];
        opposite = opposite - batch_.factor[k] * batch_.pairs[k].gap;
      }
    }
  }

  /// Adds the pairs within reach to the batch; without branches, which would be hard to predict.
  void consider(std::size_t i, std::span<const std::int32_t> others, double reach) {
    const Point* const place = place_.data();
    const double* const local = local_.data();
    NearPair* const pairs = batch_.pairs.data();
    double* const ranges = batch_.range.data();
    double* const squares = batch_.squared.data();
    double* const factors = batch_.factor.data();
    const Point here = place[i];
    const double own = local[i];
    const std::size_t n_strong = i < n_ ? n_ : 0;
    constexpr std::array<double, 2> strengths{force_of_fixed, 1};
    std::size_t n = batch_.n;
    for (const std::int32_t j : others) {
      const Vector gap = here - place[j];
      const double range = reach * (own + local[j]) / 2;
      const double squared = dot(gap, gap);
      pairs[n] = {gap, j};
      ranges[n] = range;
      squares[n] = squared;
      factors[n] = strengths[index(j) < n_strong] * range * range;
      n += static_cast<std::size_t>((squared < range * range) & (squared != 0));
    }
    batch_.n = n;
  }

  /// Factors of the gaps, which give the forces: in a loop of its own, which compilers make vector code of.
  void compute_factors() {
    const double* const __restrict range = batch_.range.data();
    const double* const __restrict squared = batch_.squared.data();
    double* const __restrict factor = batch_.factor.data();
    for (std::size_t k = 0; k < batch_.n; ++k) {
      const double distance = std::sqrt(squared[k]);
      const double overlap = 1 - distance / range[k];
      // In proportion to the square of the spacing: then the pressure is the same everywhere, and fine
      // parts do not expand into coarse ones. Stiffer at short distances, or else two points could remain
      // together in the cage of their neighbours.
      factor[k] = factor[k] * overlap * (1 + 4 * overlap * overlap) / distance;
    }
  }

  void move(std::size_t i) {
    Vector step = momentum * velocity_[i] + mobility / local_[i] * force_[i];
    double length = norm(step);
    if (length > longest_step * local_[i]) {
      step = longest_step * local_[i] / length * step;
      length = longest_step * local_[i];
    }
    // The clearance changes by no more than the way.
    headroom_[i] -= length;
    if (headroom_[i] < 0 && !has_room(i, place_[i] + step)) step = sliding(i, step);
    place_[i] = place_[i] + step;
    velocity_[i] = step;
  }

  /// The part of a step, along single axes, that remains in the room.
  Vector sliding(std::size_t i, const Vector& step) {
    Vector result{};
    for (std::size_t axis = 0; axis < 3; ++axis) {
      if (step[axis] == 0) continue;
      Vector longer = result;
      longer[axis] = step[axis];
      if (has_room(i, place_[i] + longer)) result = longer;
    }
    headroom_[i] = 0;
    return result;
  }

  bool has_room(std::size_t i, const Point& place) {
    headroom_[i] = room_.clearance(patch_.at(place)) - room_.margin * local_[i];
    return headroom_[i] >= 0;
  }

  const SpacingField& spacing_;
  const Patch& patch_;
  const Room& room_;
  Crew* crew_;                         ///< null where this process alone moves the points
  std::size_t n_;                      ///< movable points, followed by the fixed ones
  std::size_t begin_, end_;            ///< own points: those whose pairs are listed here
  std::size_t movable_end_;            ///< of the own points
  std::vector<std::size_t> first_of_;  ///< first movable point of each worker, and n_
  std::vector<Point> place_;           ///< in own coordinates of the patch [m]
  std::vector<double> local_;          ///< spacing at the point [m]
  std::vector<Vector> velocity_;
  std::vector<double> headroom_;  ///< how far a point may move before its clearance is computed again [m]
  std::vector<Vector> force_;
  std::vector<Pair> before_, after_;  ///< pairs of own points listed by others with smaller, larger numbers
  NearBatch batch_;
};

constexpr double candidates_per_point = 3;

double power(double value, bool flat) {
  return flat ? value * value : value * value * value;
}

double measure(const Box& region) {
  double product = 1;
  for (std::size_t i = 0; i < 3; ++i)
    if (region.upper[i] > region.lower[i]) product *= region.upper[i] - region.lower[i];
  return product;
}

/// Calls `visit` for boxes that fill a region of the patch and are so small that the spacing varies little in
/// them, until it returns false.
template <class Visit>
bool subdivide(const SpacingField& spacing, const Patch& patch, const Box& region, const Visit& visit) {
  const std::size_t longest = longest_axis(region);
  const Point middle = region.lower + (region.upper - region.lower) / 2;
  const double length = region.upper[longest] - region.lower[longest];
  if (length <= 2 * spacing(patch.at(middle)) && length <= 4 * spacing.lower_bound(patch.bounds(region)))
    return visit(region);
  Box first = region;
  first.upper[longest] = middle[longest];
  Box second = region;
  second.lower[longest] = middle[longest];
  return subdivide(spacing, patch, first, visit) && subdivide(spacing, patch, second, visit);
}

/// True if a box is known to lie in the room, from the clearance of its middle.
bool has_room_everywhere(const SpacingField& spacing, const Patch& patch, const Room& room, const Box& cell) {
  const double clearance = room.clearance(patch.at(cell.lower + (cell.upper - cell.lower) / 2));
  return clearance - norm(cell.upper - cell.lower) / 2 >=
         room.margin * spacing.upper_bound(patch.bounds(cell));
}

/// Random points of the required density. Their number in a part of the patch is that required there, nearly
/// without scatter: every time that the sum over the candidates of the number of points that each stands for
/// passes an integer, the candidate is taken.
SpacedPoints start(const SpacingField& spacing, const Patch& patch, const Room& room, RandomStream& stream) {
  const bool flat = is_flat(patch.domain);
  const double density = candidates_per_point * (flat ? surface_density : interior_density);
  SpacedPoints result;
  double remainder = stream.uniform();
  double number = stream.uniform();
  subdivide(spacing, patch, patch.domain, [&](const Box& cell) {
    const double finest = spacing.lower_bound(patch.bounds(cell));
    const bool is_inside = has_room_everywhere(spacing, patch, room, cell);
    remainder += density * measure(cell) / power(finest, flat);
    for (; remainder >= 1; --remainder) {
      Point own = cell.lower;
      for (std::size_t i = 0; i < 3; ++i)
        if (cell.upper[i] > cell.lower[i]) own[i] = stream.uniform(cell.lower[i], cell.upper[i]);
      const Point p = patch.at(own);
      const double local = spacing(p);
      if (!is_inside && room.clearance(p) < room.margin * local) continue;
      number += power(finest, flat) / (power(local, flat) * candidates_per_point);
      if (number < 1) continue;
      --number;
      result.position.push_back(p);
      result.spacing.push_back(local);
    }
    return true;
  });
  return result;
}

}  // namespace

bool is_flat(const Box& region) {
  for (std::size_t i = 0; i < 3; ++i)
    if (region.upper[i] == region.lower[i]) return true;
  return false;
}

void repel(const SpacingField& spacing, const Patch& patch, const Room& room, const SpacedPoints& fixed,
           SpacedPoints& points, RandomStream& stream, Crew* crew) {
  Relaxation relaxation(spacing, patch, room, fixed, points, crew);
  relaxation.run();
  relaxation.shake(stream);
  points = relaxation.result();
}

std::vector<Point> blue_noise(const SpacingField& spacing, const Patch& patch, const Room& room,
                              const SpacedPoints& fixed, RandomStream stream, Crew* crew) {
  SpacedPoints points = start(spacing, patch, room, stream);
  repel(spacing, patch, room, fixed, points, stream, crew);
  return std::move(points.position);
}

double expected_points(const SpacingField& spacing, const Patch& patch, const Room& room, double limit) {
  const bool flat = is_flat(patch.domain);
  const double density = flat ? surface_density : interior_density;
  double sum = 0;
  subdivide(spacing, patch, patch.domain, [&](const Box& cell) {
    // The midpoints of 2 x 2 x 2 parts of the cell or, near the borders, of 4 x 4 x 4; 2 x 2 or 4 x 4 if
    // flat.
    const bool is_inside = has_room_everywhere(spacing, patch, room, cell);
    const unsigned n_along = is_inside ? 2 : 4;
    const unsigned n_parts = flat ? n_along * n_along : n_along * n_along * n_along;
    double mean = 0;
    for (unsigned part = 0; part < n_parts; ++part) {
      Point own = cell.lower;
      unsigned rest = part;
      for (unsigned i = 0; i < 3; ++i) {
        if (cell.upper[i] == cell.lower[i]) continue;
        own[i] += (0.5 + rest % n_along) / n_along * (cell.upper[i] - cell.lower[i]);
        rest /= n_along;
      }
      const Point p = patch.at(own);
      const double local = spacing(p);
      if (is_inside || room.clearance(p) >= room.margin * local) mean += 1 / (n_parts * power(local, flat));
    }
    sum += density * measure(cell) * mean;
    return sum <= limit;
  });
  return sum;
}

}  // namespace crackle::geometry
