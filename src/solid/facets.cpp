// SPDX-License-Identifier: GPL-3.0-or-later
#include "facets.h"

#include "common/failure.h"

#include "words.h"

#include <algorithm>
#include <map>
#include <utility>

namespace crackle::solid {

void Facets::add(Polygon polygon, int of_group) {
  polygons.push_back(std::move(polygon));
  group.push_back(of_group);
}

int Facets::group_named(const std::string& name) {
  if (name.empty()) return -1;
  const auto found = std::ranges::find(groups, name);
  if (found != groups.end()) return static_cast<int>(found - groups.begin());
  groups.push_back(name);
  return static_cast<int>(groups.size()) - 1;
}

namespace {

/// Each named solid of the file is a group.
Facets read_text_stl(const std::string& content) {
  Facets facets;
  std::map<Vector, std::size_t> numbers;  // facets repeat their corners
  Words words(content);
  int group = -1;
  std::size_t n_solids = 0, n_ended = 0;
  for (std::string_view word = words.next(); !word.empty(); word = words.next()) {
    if (word == "solid") {
      ++n_solids;
      group = facets.group_named(std::string(words.rest_of_line()));
    } else if (word == "endsolid") {
      ++n_ended;
      words.rest_of_line();
    } else if (word == "outer") {
      Polygon polygon;
      for (word = words.next(); word != "endloop" && !word.empty(); word = words.next())
        if (word == "vertex") polygon.push_back(numbers.emplace(words.point(), numbers.size()).first->second);
      facets.add(std::move(polygon), group);
    }
  }
  if (n_solids == 0 || n_ended != n_solids) fail("ends too early: \"endsolid\" is missing");
  facets.points.resize(numbers.size());
  for (const auto& [point, number] : numbers) facets.points[number] = point;
  // The name of a single solid says nothing about its faces.
  if (facets.groups.size() < 2) {
    facets.groups.clear();
    facets.group.assign(facets.group.size(), -1);
  }
  return facets;
}

Facets read_stl(const std::string& content) {
  // Binary files may begin with "solid" too.
  const bool is_text = content.starts_with("solid") && content.find("facet") != std::string::npos &&
                       content.find('\0') == std::string::npos;
  return is_text ? read_text_stl(content) : read_binary_stl(content);
}

/// Groups are those of "g"; where there are none, materials ("usemtl") or objects ("o").
Facets read_obj(const std::string& content) {
  Facets facets;
  Words words(content);
  std::map<std::string, std::string, std::less<>> current;  // name by keyword
  for (std::string_view word = words.next(); !word.empty(); word = words.next()) {
    if (word == "v") {
      facets.points.push_back(words.point());
    } else if (word == "g" || word == "usemtl" || word == "o") {
      current[std::string(word)] = words.rest_of_line();
    } else if (word == "f") {
      Polygon polygon;
      Words corners(words.rest_of_line(), words.line());
      for (word = corners.next(); !word.empty(); word = corners.next()) {
        const auto number = Words(word.substr(0, word.find('/')), words.line()).number<long>();
        // Negative numbers count from the last point.
        const auto n = static_cast<long>(facets.points.size());
        if (number == 0 || number > n || number < -n)
          fail("line {}: a facet has corner {}, but there are {} points before it", words.line(), number, n);
        polygon.push_back(static_cast<std::size_t>(number > 0 ? number - 1 : n + number));
      }
      std::string name;
      for (const char* const keyword : {"g", "usemtl", "o"})
        if (name.empty() && current.contains(keyword)) name = current[keyword];
      facets.add(std::move(polygon), facets.group_named(name));
    }
    words.rest_of_line();
  }
  if (facets.groups.size() < 2) {
    facets.groups.clear();
    facets.group.assign(facets.group.size(), -1);
  }
  return facets;
}

}  // namespace

Facets read_facets(const std::string& content, const std::string& extension) {
  const std::map<std::string, Facets (*)(const std::string&)> readers{
      {".stl", read_stl}, {".obj", read_obj},  {".off", read_off},
      {".ply", read_ply}, {".msh", read_gmsh}, {".vtk", read_vtk}};
  const auto reader = readers.find(extension);
  if (reader == readers.end()) fail("has a name of no known format");
  return reader->second(content);
}

}  // namespace crackle::solid
