// SPDX-License-Identifier: GPL-3.0-or-later
#include "geometry/flaws.h"

#include "geometry/pre_crack.h"

#include "common/failure.h"
#include "common/random.h"
#include "uncertainty/random_inputs.h"

#include <algorithm>
#include <cmath>
#include <iterator>
#include <numbers>

namespace crackle::geometry {

namespace {

/// Places tried for one flaw in a region, of which a part must lie in the body.
constexpr int most_tries = 10'000;

/// Number of points of a Poisson process with this mean.
int poisson(double mean, RandomStream stream) {
  int n = 0;
  for (double sum = -std::log1p(-stream.uniform()); sum < mean; ++n) sum -= std::log1p(-stream.uniform());
  return n;
}

/// A unit vector at an angle from a direction, of any length.
Vector tilted(const Vector& direction, double angle, double turn) {
  const Vector axis = direction / norm(direction);
  const auto [first, second] = across(axis);
  return std::cos(angle) * axis + std::sin(angle) * (std::cos(turn) * first + std::sin(turn) * second);
}

plane::PreCrack drawn_flaw(const input::Flaws& flaws, const Point& center, RandomStream& stream) {
  plane::PreCrack crack;
  crack.center = center;
  const double probability = std::max(stream.uniform(), 0x1p-53);
  const double radius = flaws.radius > 0 ? flaws.radius : uncertainty::quantile(flaws.radii, probability);
  if (!(radius > 0))
    fail("random.flaws: a radius of {:.3g} m was drawn; give a distribution above 0", radius);
  crack.semi_axes = {radius, radius};
  const double turn = 2 * std::numbers::pi * stream.uniform();
  const double angle = flaws.normal ? flaws.spread * stream.normal() : std::acos(stream.uniform(-1, 1));
  crack.normal = tilted(flaws.normal.value_or(Vector{0, 0, 1}), angle, turn);
  return crack;
}

}  // namespace

std::vector<plane::PreCrack> drawn_flaws(const input::Model& model, const Body& body, std::uint64_t sample) {
  std::vector<plane::PreCrack> cracks;
  for (std::size_t table = 0; table < model.flaws.size(); ++table) {
    const input::Flaws& flaws = model.flaws[table];
    const RandomStream all = RandomStream(model.seed, sample, "flaws").substream(table);
    Box box = body.bounds();
    double volume = 1;
    for (std::size_t i = 0; i < 3; ++i) {
      box.lower[i] = std::max(box.lower[i], flaws.region[i].first);
      box.upper[i] = std::min(box.upper[i], flaws.region[i].second);
      volume *= box.upper[i] - box.lower[i];
    }
    // Points of the process in the box that lie in the body make the process in the body.
    const int n = flaws.number ? *flaws.number : poisson(flaws.density * volume, all.substream(0));
    for (int k = 0; k < n; ++k) {
      RandomStream stream = all.substream(static_cast<std::uint64_t>(k) + 1);
      const auto place = [&] {
        Point p{};
        for (std::size_t i = 0; i < 3; ++i) p[i] = stream.uniform(box.lower[i], box.upper[i]);
        return p;
      };
      Point center = place();
      int tries = 1;
      for (; flaws.number && !body.contains(center) && tries < most_tries; ++tries) center = place();
      if (tries == most_tries)
        fail("random.flaws[{}].region: no part of the body was found in it; give a region in the body",
             table);
      if (body.contains(center)) cracks.push_back(drawn_flaw(flaws, center, stream));
    }
  }
  return cracks;
}

std::vector<plane::PreCrack> pre_cracks(const input::Model& model, const Body& body, std::uint64_t sample) {
  std::vector<plane::PreCrack> cracks = model.specimen.cracks;
  if (!model.flaws.empty()) std::ranges::move(drawn_flaws(model, body, sample), std::back_inserter(cracks));
  return cracks;
}

}  // namespace crackle::geometry
