// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "crackle/geometry/body.h"

#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <vector>

namespace crackle::analysis {

/// Crack positions in the frame of the leading crack.
///
/// Notches that a symmetry of the body maps on each other (geometry::symmetries) form a class; its notch with
/// the lowest number is the reference. A sample that another notch of the class leads is turned by the first
/// symmetry that maps this notch on the reference: its other notches go to their images, z to length - z
/// where the symmetry reflects z, and a section y to width - y where it reflects y. So a turned position
/// belongs to the section at width - y; where the input has none there (to 1e-12 of the body's largest size),
/// it belongs to no section, and only samples that need no turning in y count at y. A notch without an image
/// is a class of its own.
class LeaderFrame {
public:
  /// Where a position of a turned sample comes from: z of `notch` at `section`.
  struct Source {
    int notch;
    int section;
    std::optional<double> length;  ///< of the body along z, where z is reflected [m]
  };

  LeaderFrame(const geometry::Body& body, std::span<const double> sections);
  /// Of a body without symmetry: each notch is a class of its own.
  LeaderFrame(int n_notches, int n_sections);

  int n_notches() const { return static_cast<int>(reference_.size()); }
  int n_sections() const { return n_sections_; }

  /// Of each notch the reference notch of its class.
  const std::vector<std::int32_t>& reference() const { return reference_; }

  /// The crack of `notch` at `section` in the frame of a sample that `leading` leads; nothing where such a
  /// sample does not count.
  std::optional<Source> source(int leading, int notch, int section) const;

private:
  struct Turn {
    std::optional<double> length;  ///< see Source
    std::vector<int> notch;        ///< that each notch of the frame is in the sample
    std::vector<int> section;      ///< likewise; -1 for none
  };

  int n_sections_;
  std::vector<std::int32_t> reference_;
  std::vector<Turn> turns_;  ///< of a sample by its leading notch
};

}  // namespace crackle::analysis
