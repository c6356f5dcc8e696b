// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "crackle/geometry/body.h"
#include "crackle/input/parameters.h"

#include <cstddef>
#include <cstdint>
#include <optional>
#include <vector>

namespace crackle::analysis {

/// Crack positions in the frame of the leading crack.
///
/// Notches (any crack starts) that a symmetry of the body maps on each other form a class; its notch with
/// the lowest number is the reference. A sample that another notch of the class leads is turned by the first
/// symmetry that maps this notch on the reference: its other notches go to their images, and y and z to
/// width - y and length - z where the symmetry reflects them. So a position turned across its section belongs
/// to the section at width - y or length - z; where the input has none there (to 1e-12 of the body's largest
/// size), it belongs to no section, and only samples that need no turning across the section count at it. A
/// line belongs to the one whose ends are its images; where those are the other way round, positions are its
/// length minus those there. A
/// notch without an image is a class of its own.
class LeaderFrame {
public:
  /// Where a position of a turned sample comes from: that of `notch` at `section`.
  struct Source {
    int notch;
    int section;
    std::optional<double>
        extent;  ///< of the body, or the line, along the position, where that is reflected [m]
  };

  LeaderFrame(const geometry::Body& body, const input::Sections& sections);
  /// Of a body without symmetry: each notch is a class of its own.
  LeaderFrame(int n_notches, int n_sections);

  int n_notches() const { return static_cast<int>(reference_.size()); }
  int n_sections() const { return n_sections_; }

  /// Of each notch the reference notch of its class.
  const std::vector<std::int32_t>& reference() const { return reference_; }

  /// The axes that the symmetry reflects which turns a sample led by `leading`: bit 1 for y, 2 for z.
  std::uint8_t reflected_axes(int leading) const { return turns_[static_cast<std::size_t>(leading)].axes; }

  /// Of each notch of the frame the notch that it is in a sample led by `leading`.
  const std::vector<int>& notches(int leading) const {
    return turns_[static_cast<std::size_t>(leading)].notch;
  }

  /// The crack of `notch` at `section` in the frame of a sample that `leading` leads; nothing where such a
  /// sample does not count.
  std::optional<Source> source(int leading, int notch, int section) const;

private:
  struct Turn {
    std::uint8_t axes;                          ///< reflected
    std::vector<int> notch;                     ///< that each notch of the frame is in the sample
    std::vector<int> section;                   ///< likewise; -1 for none
    std::vector<std::optional<double>> extent;  ///< of each section, see Source
  };

  int n_sections_;
  std::vector<std::int32_t> reference_;
  std::vector<Turn> turns_;  ///< of a sample by its leading notch
};

}  // namespace crackle::analysis
