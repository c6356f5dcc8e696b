// SPDX-License-Identifier: GPL-3.0-or-later
// Inputs of plates with any outline, a family of random ones, and the reasons to refuse one, determined on a
// raster of points without the program's geometry.
#pragma once

#include "common/random.h"
#include "support/effort.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <string>
#include <utility>
#include <vector>

namespace crackle::test {

/// An input of a plate: the keys of its tables as written in a file.
struct PlateText {
  std::string specimen;
  std::vector<std::string> holes = {};
  std::vector<std::string> notches = {};
  std::string mesh = "spacing = \"1 mm\"";
  std::string section = "10 mm";
  double poisson_ratio = 0.38;
  std::string boundaries = "[[boundary]]\non = \"x-min\"\nfix = [\"x\", \"y\", \"z\"]\n";

  std::string text() const {
    std::string result = "[ensemble]\nsamples = 1\n[specimen]\n" + specimen + "\n";
    for (const std::string& hole : holes) result += "[[specimen.hole]]\n" + hole + "\n";
    for (const std::string& notch : notches) result += "[[specimen.notch]]\n" + notch + "\n";
    return result + "[mesh]\nbase = \"shared\"\n" + mesh +
           "\n[material]\npoisson_ratio = " + fmt::format("{}", poisson_ratio) +
           R"(
youngs_modulus = "3300 MPa"
density = "1180 kg/m^3"
[fracture]
strength = "35 MPa"
impulse = "1e-8 MPa^2 s"
)" + boundaries +
           R"([time]
duration = "50 us"
[sections]
y = [")" + section +
           "\"]\n";
  }
};

/// A random plate in a square of 20 mm, all lengths in mm.
struct RandomPlate : PlateText {
  using Place = std::array<double, 2>;
  struct Ellipse {
    Place centre;
    std::array<double, 2> axes;
    double angle;  // degrees
    bool contains(const Place& p, double margin = 0) const {
      const double c = std::cos(angle * std::numbers::pi / 180);
      const double s = std::sin(angle * std::numbers::pi / 180);
      const double u = (c * (p[0] - centre[0]) + s * (p[1] - centre[1])) / (axes[0] + margin);
      const double v = (-s * (p[0] - centre[0]) + c * (p[1] - centre[1])) / (axes[1] + margin);
      return u * u + v * v < 1;
    }
  };
  struct Slot {
    Place from, to;
    double height;
    std::array<bool, 2> is_round;  // at from and to
    bool contains(const Place& p, double margin = 0) const {
      const double length = std::hypot(to[0] - from[0], to[1] - from[1]);
      const Place along{(to[0] - from[0]) / length, (to[1] - from[1]) / length};
      const double way = along[0] * (p[0] - from[0]) + along[1] * (p[1] - from[1]);
      const double side = along[0] * (p[1] - from[1]) - along[1] * (p[0] - from[0]);
      // The centre of a half circle is half a height before its end.
      const double before = height / 2 - way;
      const double beyond = way - (length - height / 2);
      if (is_round[0] && before > 0 && std::hypot(before, side) >= height / 2 + margin) return false;
      if (is_round[1] && beyond > 0 && std::hypot(beyond, side) >= height / 2 + margin) return false;
      return way > -margin && way < length + margin && std::abs(side) < height / 2 + margin;
    }
  };

  std::vector<Place> corners;  ///< of the outline; empty for a circle of radius 10 around (10, 10)
  std::vector<Ellipse> ellipses;
  std::vector<Slot> slots;
  double min_quality = 0.2;

  bool in_outline(const Place& p) const {
    if (corners.empty()) return std::hypot(p[0] - 10, p[1] - 10) < 10;
    double angle = 0;
    for (std::size_t i = 0; i < corners.size(); ++i) {
      const Place& a = corners[i];
      const Place& b = corners[(i + 1) % corners.size()];
      const Place u{a[0] - p[0], a[1] - p[1]};
      const Place v{b[0] - p[0], b[1] - p[1]};
      angle += std::atan2(u[0] * v[1] - u[1] * v[0], u[0] * v[0] + u[1] * v[1]);
    }
    return std::abs(angle) > std::numbers::pi;
  }

  static constexpr int n_raster = 400;
  static constexpr double cell = 22.0 / n_raster;
  static Place place(int i, int j) { return {-1 + (i + 0.5) * cell, -1 + (j + 0.5) * cell}; }

  /// The number of raster points in each connected piece of the plate, largest first.
  std::vector<int> pieces() const {
    std::vector<int> state(n_raster * n_raster, 0);
    for (int i = 0; i < n_raster; ++i)
      for (int j = 0; j < n_raster; ++j) {
        const Place p = place(i, j);
        state[static_cast<std::size_t>(i * n_raster + j)] =
            in_outline(p) &&
            std::ranges::none_of(ellipses, [&](const auto& some) { return some.contains(p); }) &&
            std::ranges::none_of(slots, [&](const auto& some) { return some.contains(p); });
      }
    std::vector<int> sizes;
    std::vector<int> stack;
    for (int start = 0; start < n_raster * n_raster; ++start) {
      if (state[static_cast<std::size_t>(start)] != 1) continue;
      sizes.push_back(0);
      stack = {start};
      state[static_cast<std::size_t>(start)] = 2;
      while (!stack.empty()) {
        const int at = stack.back();
        stack.pop_back();
        ++sizes.back();
        for (const int next : {at - 1, at + 1, at - n_raster, at + n_raster})
          if (next >= 0 && next < n_raster * n_raster && state[static_cast<std::size_t>(next)] == 1) {
            state[static_cast<std::size_t>(next)] = 2;
            stack.push_back(next);
          }
      }
    }
    std::ranges::sort(sizes, std::ranges::greater{});
    return sizes;
  }

  /// [m^2], by counting raster points.
  double area() const {
    int n = 0;
    for (const int size : pieces()) n += size;
    return n * cell * cell * 1e-6;
  }
  /// A raster is off by one cell's width along half of the boundary; chords cut off slightly more.
  double area_tolerance() const { return (0.02 * 400 + 0.5 * cell * 150) * 1e-6; }

  template <class One, class Other>
  static bool come_near(const One& one, const Other& other, double margin) {
    for (int i = 0; i < n_raster; ++i)
      for (int j = 0; j < n_raster; ++j)
        if (one.contains(place(i, j), margin) && other.contains(place(i, j), margin)) return true;
    return false;
  }

  bool cutters_come_near(double margin) const {
    bool near = false;
    for (std::size_t i = 0; i < ellipses.size(); ++i) {
      for (std::size_t j = 0; j < i; ++j) near = near || come_near(ellipses[i], ellipses[j], margin);
      for (const Slot& slot : slots) near = near || come_near(ellipses[i], slot, margin);
    }
    for (std::size_t i = 0; i < slots.size(); ++i)
      for (std::size_t j = 0; j < i; ++j) near = near || come_near(slots[i], slots[j], margin);
    return near;
  }

  /// True if a cutter has no border that is the plate's.
  bool cutter_is_hidden() const {
    const auto n_outside = [this](const auto& cutter) {
      int n = 0;
      for (int i = 0; i < n_raster; ++i)
        for (int j = 0; j < n_raster; ++j) {
          const Place p = place(i, j);
          const auto holds = [&](const auto& other) {
            return static_cast<const void*>(&other) != &cutter && other.contains(p, cell);
          };
          n += cutter.contains(p) && in_outline(p) && std::ranges::none_of(ellipses, holds) &&
               std::ranges::none_of(slots, holds);
        }
      return n;
    };
    return std::ranges::any_of(ellipses, [&](const auto& one) { return n_outside(one) == 0; }) ||
           std::ranges::any_of(slots, [&](const auto& one) { return n_outside(one) == 0; });
  }

  bool hole_leaves(double margin) const {
    for (int i = 0; i < n_raster; ++i)
      for (int j = 0; j < n_raster; ++j)
        for (const Ellipse& some : ellipses)
          if (some.contains(place(i, j), margin) && !in_outline(place(i, j))) return true;
    return false;
  }

  bool cutter_is_outside() const {
    const auto is_outside = [this](const auto& cutter) {
      int n = 0;
      for (int i = 0; i < n_raster; ++i)
        for (int j = 0; j < n_raster; ++j) n += cutter.contains(place(i, j), -0.2) && in_outline(place(i, j));
      return n == 0;
    };
    return std::ranges::any_of(slots, is_outside) || std::ranges::any_of(ellipses, is_outside);
  }

  /// Why no such plate exists, as far as a raster can tell; empty if it does.
  std::string impossible() const {
    const std::vector<int> sizes = pieces();
    if (sizes.size() > 1 && sizes[1] > 12) return "in two pieces";
    // Chords deviate by up to a tenth of a curve's radius.
    if (hole_leaves(-0.3)) return "a hole crosses the edge";
    return "";
  }

  /// The true reason for a refusal, identified by its message; empty if the message is wrong.
  std::string true_reason(const std::string& refusal) const {
    const auto says = [&](const char* words) { return refusal.find(words) != std::string::npos; };
    const double doubt = 2 * cell;
    if (says("let them overlap") && cutters_come_near(doubt)) return "cutters touch";
    if (says("lies in other holes or notches") && cutter_is_hidden()) return "a cutter in others";
    if (says("leave more than") && cutters_come_near(doubt)) return "cutters leave a sliver";
    if (says("crosses the edge") && hole_leaves(doubt)) return "a hole crosses the edge";
    if (says("cuts the body in") && pieces().size() > 1) return "in two pieces";
    if (says("lies outside the body") && cutter_is_outside()) return "a hole or slot outside";
    if (says("degrees, which limits the quality there")) return sharpest() < 20 ? "a sharp corner" : "";
    if (says("is too high for a slot")) return "a slot higher than long";
    return "";
  }

  /// The sharpest angle of the outline, or between a slot and an edge that it cuts [degrees].
  double sharpest() const {
    if (!slots.empty() || cutters_come_near(2 * cell)) return 0;
    double least = 360;
    for (std::size_t i = 0; i < corners.size(); ++i) {
      const Place& p = corners[i];
      const Place& a = corners[(i + 1) % corners.size()];
      const Place& b = corners[(i + corners.size() - 1) % corners.size()];
      const double angle = std::abs(std::remainder(
          std::atan2(a[1] - p[1], a[0] - p[0]) - std::atan2(b[1] - p[1], b[0] - p[0]), 2 * std::numbers::pi));
      least = std::min(least, angle * 180 / std::numbers::pi);
    }
    return least;
  }
};

inline RandomPlate random_plate(RandomStream stream) {
  RandomPlate plate;
  const auto number = [&](int n) { return static_cast<int>(stream.uniform(0, n)); };
  const double thickness = stream.uniform(0.5, 4);
  const int kind = number(4);
  if (kind == 0) {
    plate.specimen =
        fmt::format("thickness = \"{} mm\"\noutline = \"circle\"\nradius = \"10 mm\"", thickness);
  } else if (kind == 1) {
    plate.corners = {{0, 0}, {20, 0}, {20, 20}, {0, 20}};
    plate.specimen = fmt::format("size = [\"{} mm\", \"20 mm\", \"20 mm\"]", thickness);
  } else {
    const int n = 3 + number(8);
    std::string text;
    for (int i = 0; i < n; ++i) {
      const double angle = 2 * std::numbers::pi * (i + stream.uniform(0, 0.8)) / n;
      const double radius = stream.uniform(5, 10);
      plate.corners.push_back({10 + radius * std::cos(angle), 10 + radius * std::sin(angle)});
      text += fmt::format("{}[\"{} mm\", \"{} mm\"]", i == 0 ? "" : ", ", plate.corners.back()[0],
                          plate.corners.back()[1]);
    }
    plate.specimen = fmt::format("thickness = \"{} mm\"\noutline = [{}]", thickness, text);
  }
  const int n_holes = number(3);
  for (int i = 0; i < n_holes; ++i) {
    const bool is_circle = number(2) == 0;
    const double a = stream.uniform(0.5, 3);
    const RandomPlate::Ellipse hole{{stream.uniform(3, 17), stream.uniform(3, 17)},
                                    {a, is_circle ? a : stream.uniform(0.5, 3)},
                                    is_circle ? 0 : stream.uniform(0, 180)};
    plate.ellipses.push_back(hole);
    const std::string centre =
        fmt::format("center = [\"{} mm\", \"{} mm\"]\n", hole.centre[0], hole.centre[1]);
    plate.holes.push_back(
        centre + (is_circle ? fmt::format("radius = \"{} mm\"", a)
                            : fmt::format("semi_axes = [\"{} mm\", \"{} mm\"]\nangle = \"{} degree\"", a,
                                          hole.axes[1], hole.angle)));
  }
  const int n_slots = number(3);
  for (int i = 0; i < n_slots; ++i) {
    const bool is_round = number(2) == 0;
    RandomPlate::Slot slot{{stream.uniform(0, 20), stream.uniform(0, 20)},
                           {stream.uniform(4, 16), stream.uniform(4, 16)},
                           stream.uniform(0.3, 1.5),
                           {}};
    if (number(8) == 0 && !plate.corners.empty()) slot.from = plate.corners[0];  // at a corner
    slot.is_round = {is_round && plate.in_outline(slot.from), is_round && plate.in_outline(slot.to)};
    plate.slots.push_back(slot);
    plate.notches.push_back(fmt::format(
        "from = [\"{} mm\", \"{} mm\"]\nto = [\"{} mm\", \"{} mm\"]\nheight = \"{} mm\"\nend = \"{}\"",
        slot.from[0], slot.from[1], slot.to[0], slot.to[1], slot.height, is_round ? "round" : "square"));
  }
  const double spacing = std::min(thickness, stream.uniform(0.8, 2.5));
  plate.min_quality = stream.uniform(0.05, 0.2);
  plate.mesh = fmt::format(
      "spacing = \"{} mm\"\nnotch_spacing = \"{} mm\"\nperturbation = {}\nmin_quality = {}\ngrowth = {}",
      spacing, spacing * stream.uniform(0.3, 1), stream.uniform(0, 0.3), plate.min_quality,
      stream.uniform(0.05, 0.5));
  return plate;
}

}  // namespace crackle::test
