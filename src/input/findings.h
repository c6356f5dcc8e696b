// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <fmt/format.h>

#include <filesystem>
#include <map>
#include <string>
#include <utility>
#include <vector>

namespace crackle::input {

/// Where the keys of a file stand, and what is wrong with them.
///
/// Keys are named by their full path, elements of arrays with their number from 0:
/// "specimen.notch[1].depth".
class Findings {
public:
  void locate(const std::string& key, int line) { lines_[key] = line; }

  /// Whether the file has the key.
  bool given(const std::string& key) const { return lines_.contains(key); }

  /// An error at the key's place, or at that of the nearest table above it.
  void report(const std::string& key, const std::string& message);
  void report(const std::string& key, int line, const std::string& message);
  template <class... Arguments>
  void report(const std::string& key, fmt::format_string<Arguments...> message, Arguments&&... arguments) {
    report(key, fmt::format(message, std::forward<Arguments>(arguments)...));
  }

  /// Whether there is an error at the key, at something inside it or at a table that it is in; values that
  /// depend on it cannot be judged then.
  bool faulty(const std::string& key) const;

  bool empty() const { return findings_.empty(); }

  /// "file:line: key: message" for each error (line 0, of a text without a file, is left out), in the
  /// order of the lines; the last line counts those beyond the first hundred.
  std::vector<std::string> messages(const std::filesystem::path& file) const;

private:
  struct Finding {
    int line;
    std::string key;
    std::string message;
  };
  std::map<std::string, int> lines_;
  std::vector<Finding> findings_;
};

}  // namespace crackle::input
