// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <cstddef>
#include <cstdint>
#include <cstring>
#include <span>
#include <stdexcept>
#include <string>
#include <type_traits>
#include <vector>

/// Small mixed values (numbers, strings, arrays) as one run of bytes between ranks of the same architecture.
namespace crackle {

class Packer {
public:
  template <class T>
  void put(const T& value) {
    static_assert(std::is_trivially_copyable_v<T> && !std::is_pointer_v<T>);
    append(std::as_bytes(std::span(&value, 1)));
  }
  void put(const std::string& text) {
    put<std::uint64_t>(text.size());
    append(std::as_bytes(std::span(text)));
  }
  template <class T>
  void put(const std::vector<T>& values) {
    static_assert(std::is_trivially_copyable_v<T>);
    put<std::uint64_t>(values.size());
    append(std::as_bytes(std::span(values)));
  }
  const std::vector<std::byte>& bytes() const { return bytes_; }

private:
  void append(std::span<const std::byte> part) { bytes_.insert(bytes_.end(), part.begin(), part.end()); }
  std::vector<std::byte> bytes_;
};

/// Takes values out in the order in which they were put in.
/// @throws std::runtime_error when the bytes end too early
class Unpacker {
public:
  explicit Unpacker(std::span<const std::byte> bytes) : rest_(bytes) {}

  template <class T>
  T get() {
    static_assert(std::is_trivially_copyable_v<T>);
    T value;
    std::memcpy(&value, take(1, sizeof(T)).data(), sizeof(T));
    return value;
  }
  std::string get_string() {
    const auto part = take(get<std::uint64_t>(), 1);
    return {reinterpret_cast<const char*>(part.data()), part.size()};
  }
  template <class T>
  std::vector<T> get_vector() {
    static_assert(std::is_trivially_copyable_v<T>);
    const auto part = take(get<std::uint64_t>(), sizeof(T));
    std::vector<T> values(part.size() / sizeof(T));
    if (!values.empty()) std::memcpy(values.data(), part.data(), part.size());
    return values;
  }
  bool empty() const { return rest_.empty(); }

private:
  std::span<const std::byte> take(std::size_t count, std::size_t element) {
    if (count > rest_.size() / element) throw std::runtime_error("a packed message ends too early");
    const auto part = rest_.first(count * element);
    rest_ = rest_.subspan(count * element);
    return part;
  }
  std::span<const std::byte> rest_;
};

}  // namespace crackle
