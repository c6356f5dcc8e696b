// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <cstddef>
#include <cstdint>
#include <cstring>
#include <optional>
#include <span>
#include <stdexcept>
#include <string>
#include <type_traits>
#include <vector>

/// Serializes small mixed values for ranks of the same architecture: numbers, strings, and vectors, optionals
/// and structures of anything packable. A structure names its members once, for both directions, in a
/// function found by argument-dependent lookup: for_each_field(structure, visit) calls visit(members...).
namespace crackle {

template <class T>
inline constexpr bool is_list = false;
template <class T>
inline constexpr bool is_list<std::vector<T>> = true;
template <>
inline constexpr bool is_list<std::string> = true;

template <class T>
inline constexpr bool is_optional = false;
template <class T>
inline constexpr bool is_optional<std::optional<T>> = true;

class Packer {
public:
  template <class T>
  void put(const T& value) {
    if constexpr (is_optional<T>) {
      put(value.has_value());
      if (value) put(*value);
    } else if constexpr (is_list<T>) {
      put<std::uint64_t>(value.size());
      if constexpr (std::is_trivially_copyable_v<typename T::value_type>)
        append(std::as_bytes(std::span(value)));
      else
        for (const auto& one : value) put(one);
    } else if constexpr (std::is_trivially_copyable_v<T>) {
      static_assert(!std::is_pointer_v<T>);
      append(std::as_bytes(std::span(&value, 1)));
    } else {
      for_each_field(value, [this](const auto&... fields) { (this->put(fields), ...); });
    }
  }

  const std::vector<std::byte>& bytes() const { return bytes_; }

private:
  void append(std::span<const std::byte> part) { bytes_.insert(bytes_.end(), part.begin(), part.end()); }

  std::vector<std::byte> bytes_;
};

/// Extracts values in the order in which they were put in.
/// @throws std::runtime_error when the bytes end too early
class Unpacker {
public:
  explicit Unpacker(std::span<const std::byte> bytes) : rest_(bytes) {}

  template <class T>
  T get() {
    T value{};
    get(value);
    return value;
  }

  bool empty() const { return rest_.empty(); }

private:
  template <class T>
  void get(T& value) {
    if constexpr (is_optional<T>) {
      if (get<bool>()) get(value.emplace());
    } else if constexpr (is_list<T>) {
      using Value = typename T::value_type;
      const auto n = get<std::uint64_t>();
      if constexpr (std::is_trivially_copyable_v<Value>) {
        const auto part = take(n, sizeof(Value));
        value.resize(n);
        if (n > 0) std::memcpy(value.data(), part.data(), part.size());
      } else {
        for (std::uint64_t i = 0; i < n; ++i) get(value.emplace_back());
      }
    } else if constexpr (std::is_trivially_copyable_v<T>) {
      std::memcpy(&value, take(1, sizeof(T)).data(), sizeof(T));
    } else {
      for_each_field(value, [this](auto&... fields) { (this->get(fields), ...); });
    }
  }

  std::span<const std::byte> take(std::size_t count, std::size_t element) {
    if (count > rest_.size() / element) throw std::runtime_error("a packed message ends too early");
    const auto part = rest_.first(count * element);
    rest_ = rest_.subspan(count * element);
    return part;
  }

  std::span<const std::byte> rest_;
};

template <class T>
std::vector<std::byte> to_bytes(const T& value) {
  Packer packer;
  packer.put(value);
  return packer.bytes();
}

/// @throws std::runtime_error unless the bytes are exactly one value
template <class T>
T from_bytes(std::span<const std::byte> bytes) {
  Unpacker unpacker(bytes);
  auto value = unpacker.get<T>();
  if (!unpacker.empty()) throw std::runtime_error("a packed message is too long");
  return value;
}

}  // namespace crackle
