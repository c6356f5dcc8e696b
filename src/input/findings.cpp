// SPDX-License-Identifier: GPL-3.0-or-later
#include "findings.h"

#include "common/printable.h"
#include "common/quantity_text.h"

#include <algorithm>

namespace crackle::input {

namespace {

bool is_inside(const std::string& key, const std::string& outer) {
  if (key.size() < outer.size() || key.compare(0, outer.size(), outer) != 0) return false;
  return key.size() == outer.size() || key[outer.size()] == '.' || key[outer.size()] == '[';
}

}  // namespace

int Findings::line_of(const std::string& key) const {
  std::string place = key;
  while (!place.empty() && !given(place)) {
    const auto separator = place.find_last_of(".[");
    place.erase(separator == std::string::npos ? 0 : separator);
  }
  const auto found = lines_.find(place);
  return found == lines_.end() ? 1 : found->second;
}

void Findings::report(const std::string& key, const std::string& message) {
  report(key, line_of(key), message);
}

void Findings::report(const std::string& key, int line, const std::string& message) {
  findings_.push_back({line, key, message});
}

bool Findings::faulty(const std::string& key) const {
  return std::any_of(findings_.begin(), findings_.end(), [&](const Finding& finding) {
    return is_inside(key, finding.key) || is_inside(finding.key, key);
  });
}

void Findings::note(const std::string& key, int line, const std::string& message) {
  notes_.push_back({line, "warning: " + key, message});
}

std::vector<std::string> Findings::messages(const std::filesystem::path& file) const {
  return lines(file, findings_);
}

std::vector<std::string> Findings::notes(const std::filesystem::path& file) const {
  return lines(file, notes_);
}

std::vector<std::string> Findings::lines(const std::filesystem::path& file, std::vector<Finding> sorted) {
  std::stable_sort(sorted.begin(), sorted.end(),
                   [](const Finding& a, const Finding& b) { return a.line < b.line; });
  constexpr std::size_t max_messages = 100;
  std::vector<std::string> result;
  for (const Finding& finding : sorted) {
    const std::string place =
        finding.line > 0 ? fmt::format("{}:{}", file.string(), finding.line) : file.string();
    if (result.size() == max_messages) {
      result.push_back(fmt::format("{}: {}", place, count_text(sorted.size() - max_messages, "more error")));
      break;
    }
    const std::string key = finding.key.empty() ? "" : finding.key + ": ";
    result.push_back(printable(fmt::format("{}: {}{}", place, key, finding.message)));
  }
  return result;
}

}  // namespace crackle::input
