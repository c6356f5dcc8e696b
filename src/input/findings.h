// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <fmt/format.h>

#include <filesystem>
#include <map>
#include <string>
#include <utility>
#include <vector>

namespace crackle::input {

/// Locations of the keys of a file, and the errors found.
///
/// Keys are named by their full path, with array indices from 0: "specimen.notch[1].depth".
class Findings {
public:
  void locate(const std::string& key, int line) { lines_[key] = line; }

  /// True if the file contains the key.
  bool given(const std::string& key) const { return lines_.contains(key); }

  /// The line of the key, or of its nearest enclosing table.
  int line_of(const std::string& key) const;

  /// Reports an error at the key's line, or at that of its nearest enclosing table.
  void report(const std::string& key, const std::string& message);
  void report(const std::string& key, int line, const std::string& message);
  template <class... Arguments>
  void report(const std::string& key, fmt::format_string<Arguments...> message, Arguments&&... arguments) {
    report(key, fmt::format(message, std::forward<Arguments>(arguments)...));
  }

  /// Records a remark, which is no error.
  void note(const std::string& key, int line, const std::string& message);
  /// At the key's line.
  void note(const std::string& key, const std::string& message) { note(key, line_of(key), message); }

  /// True if there is an error at the key, inside it or at an enclosing table; values that depend on it
  /// cannot be checked then.
  bool faulty(const std::string& key) const;

  bool empty() const { return findings_.empty(); }

  /// "file:line: key: message" for each error (line 0, for text without a file, is omitted), sorted by line;
  /// the last line counts those beyond the first hundred.
  std::vector<std::string> messages(const std::filesystem::path& file) const;

  /// The remarks, in the same form.
  std::vector<std::string> notes(const std::filesystem::path& file) const;

private:
  struct Finding {
    int line;
    std::string key;
    std::string message;
  };
  static std::vector<std::string> lines(const std::filesystem::path& file, std::vector<Finding> sorted);

  std::map<std::string, int> lines_;
  std::vector<Finding> findings_, notes_;
};

}  // namespace crackle::input
