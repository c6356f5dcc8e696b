// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "common/index.h"

#include <cstdint>
#include <type_traits>
#include <utility>
#include <vector>

namespace crackle::mechanics {

/// A property of the local tetrahedra of a subdomain: one value for all, or one for each.
template <class T>
class TetrahedronField {
public:
  explicit(!std::is_arithmetic_v<T>) TetrahedronField(T common) : values_{std::move(common)} {}
  /// @param values of each local tetrahedron; if all are equal they are stored once
  explicit TetrahedronField(std::vector<T> values) : values_(std::move(values)) {
    for (const T& value : values_)
      if (!(value == values_.front())) {
        is_uniform_ = false;
        return;
      }
    // A rank without tetrahedra needs no value.
    values_.resize(1, T{});
    values_.shrink_to_fit();
  }

  const T& operator[](std::int32_t tetrahedron) const {
    return is_uniform_ ? values_.front() : values_[index(tetrahedron)];
  }
  bool is_uniform() const { return is_uniform_; }
  /// The values that occur, some of them repeatedly.
  const std::vector<T>& values() const { return values_; }

private:
  std::vector<T> values_;
  bool is_uniform_ = true;
};

}  // namespace crackle::mechanics
