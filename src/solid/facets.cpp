// SPDX-License-Identifier: GPL-3.0-or-later
#include "facets.h"

#include "common/failure.h"
#include "common/printable.h"

#include "words.h"

#include <boost/algorithm/string/predicate.hpp>

#include <algorithm>
#include <array>
#include <bit>
#include <cstdint>
#include <map>
#include <string_view>
#include <utility>

namespace crackle::solid {

void Facets::add(Polygon polygon, int of_group) {
  polygons.push_back(std::move(polygon));
  group.push_back(of_group);
}

int Facets::group_named(const std::string& text) {
  if (text.empty()) return -1;
  const std::string name = printable(text);
  const auto found = std::ranges::find(groups, name);
  if (found != groups.end()) return static_cast<int>(found - groups.begin());
  groups.push_back(name);
  return static_cast<int>(groups.size()) - 1;
}

namespace {

/// The name of all facets tells none from the others.
void leave_out_single_group(Facets& facets) {
  if (facets.groups.size() != 1 || std::ranges::find(facets.group, -1) != facets.group.end()) return;
  facets.groups.clear();
  std::ranges::fill(facets.group, -1);
}

/// Each named solid of the file is a group.
Facets read_text_stl(const std::string& content) {
  Facets facets;
  std::map<Vector, std::size_t> numbers;  // facets repeat their corners
  Words words(content);
  int group = -1;
  std::size_t n_solids = 0, n_ended = 0;
  for (std::string_view word = words.next(); !word.empty(); word = words.next()) {
    if (boost::iequals(word, "solid")) {
      ++n_solids;
      group = facets.group_named(std::string(words.rest_of_line()));
    } else if (boost::iequals(word, "endsolid")) {
      ++n_ended;
      words.rest_of_line();
    } else if (boost::iequals(word, "outer")) {
      Polygon polygon;
      for (word = words.next(); !boost::iequals(word, "endloop") && !word.empty(); word = words.next())
        if (boost::iequals(word, "vertex"))
          polygon.push_back(numbers.emplace(words.point(), numbers.size()).first->second);
      facets.add(std::move(polygon), group);
    }
  }
  if (n_solids == 0 || n_ended != n_solids) fail("ends too early: \"endsolid\" is missing");
  facets.points.resize(numbers.size());
  for (const auto& [point, number] : numbers) facets.points[number] = point;
  leave_out_single_group(facets);
  return facets;
}

/// Takes values one after the other from the start of some bytes.
class Bytes {
public:
  Bytes(std::string_view rest, bool is_reversed) : rest_(rest), is_reversed_(is_reversed) {}

  template <class Number>
  Number number() {
    std::array<char, sizeof(Number)> raw{};
    if (rest_.size() < raw.size()) fail("ends too early");
    std::copy_n(rest_.begin(), raw.size(), raw.begin());
    if (is_reversed_) std::ranges::reverse(raw);
    rest_.remove_prefix(raw.size());
    return std::bit_cast<Number>(raw);
  }
  void skip(std::size_t n) {
    if (rest_.size() < n) fail("ends too early");
    rest_.remove_prefix(n);
  }

private:
  std::string_view rest_;
  bool is_reversed_;
};

Facets read_binary_stl(const std::string& content) {
  Facets facets;
  Bytes bytes(content, false);
  bytes.skip(80);
  for (auto n = bytes.number<std::uint32_t>(); n > 0; --n) {
    bytes.skip(12);  // the normal
    Polygon polygon;
    for (int i = 0; i < 3; ++i) {
      polygon.push_back(facets.points.size());
      Vector& p = facets.points.emplace_back();
      for (double& coordinate : p) coordinate = static_cast<double>(bytes.number<float>());
    }
    bytes.skip(2);
    facets.add(std::move(polygon));
  }
  return facets;
}

Facets read_off(const std::string& content) {
  std::string text = content;
  bool is_comment = false;
  for (char& c : text) {
    is_comment = c != '\n' && (is_comment || c == '#');
    if (is_comment) c = ' ';
  }
  Words words(text);
  if (!words.next().ends_with("OFF")) fail("does not begin with \"OFF\"");
  Facets facets;
  facets.points.resize(words.count());
  const std::size_t n = words.count();
  words.next();  // the number of edges
  for (Vector& p : facets.points) {
    p = words.point();
    words.rest_of_line();  // normals or colours
  }
  for (std::size_t i = 0; i < n; ++i) {
    Polygon polygon(words.count());
    for (std::size_t& corner : polygon) corner = words.number<std::size_t>();
    words.rest_of_line();
    facets.add(std::move(polygon));
  }
  return facets;
}

class PlyReader {
public:
  explicit PlyReader(const std::string& content)
      : words_(content), header_(content), content_(content), bytes_({}, false) {}

  Facets read() {
    read_header();
    for (const Element& element : elements_)
      for (std::size_t i = 0; i < element.n; ++i) read_element(element);
    return std::move(facets_);
  }

private:
  struct Property {
    std::string name, type, count_type;  ///< the last one of lists only
  };
  struct Element {
    std::string name;
    std::size_t n;
    std::vector<Property> properties;
  };

  void read_header() {
    if (header_.next() != "ply") fail("does not begin with \"ply\"");
    for (std::string_view word = header_.next(); word != "end_header"; word = header_.next()) {
      if (word.empty()) fail("ends too early: \"end_header\" is missing");
      if (word == "format") {
        format_ = header_.next();
      } else if (word == "element") {
        const std::string name(header_.next());
        elements_.push_back({name, header_.count(), {}});
      } else if (word == "property" && !elements_.empty()) {
        Property property;
        property.type = header_.next();
        if (property.type == "list") {
          property.count_type = header_.next();
          property.type = header_.next();
        }
        property.name = header_.next();
        elements_.back().properties.push_back(std::move(property));
      }
      header_.rest_of_line();
    }
    header_.rest_of_line();
    if (format_ == "ascii") {
      words_ = header_;
    } else if (format_ == "binary_little_endian" || format_ == "binary_big_endian") {
      const std::size_t start = content_.find('\n', content_.find("end_header"));
      bytes_ = Bytes(std::string_view(content_).substr(std::min(start, content_.size() - 1) + 1),
                     format_ == "binary_big_endian");
    } else {
      fail("has the format \"{}\"", shown(format_));
    }
  }

  static std::string shown(const std::string& word) { return word.substr(0, 40); }

  double value(const std::string& type) {
    if (format_ == "ascii") return words_.number<double>();
    if (type == "float" || type == "float32") return static_cast<double>(bytes_.number<float>());
    if (type == "double" || type == "float64") return bytes_.number<double>();
    if (type == "char" || type == "int8") return bytes_.number<std::int8_t>();
    if (type == "uchar" || type == "uint8") return bytes_.number<std::uint8_t>();
    if (type == "short" || type == "int16") return bytes_.number<std::int16_t>();
    if (type == "ushort" || type == "uint16") return bytes_.number<std::uint16_t>();
    if (type == "int" || type == "int32") return bytes_.number<std::int32_t>();
    if (type == "uint" || type == "uint32") return bytes_.number<std::uint32_t>();
    fail("has numbers of type \"{}\"", shown(type));
  }

  void read_element(const Element& element) {
    Vector p{};
    Polygon polygon;
    for (const Property& property : element.properties) {
      if (property.count_type.empty()) {
        const double number = value(property.type);
        for (std::size_t i = 0; i < 3; ++i)
          if (property.name == std::string(1, "xyz"[i])) p[i] = number;
        continue;
      }
      const double n = value(property.count_type);
      if (!(n >= 0 && n <= static_cast<double>(content_.size()))) fail("has a facet with {} corners", n);
      const bool is_facet = property.name == "vertex_indices" || property.name == "vertex_index";
      for (double k = 0; k < n; ++k) {
        const double number = value(property.type);
        if (is_facet && !(number >= 0 && number < static_cast<double>(facets_.points.size())))
          fail("has a facet with corner {}, but only {} points", number, facets_.points.size());
        if (is_facet) polygon.push_back(static_cast<std::size_t>(number));
      }
    }
    if (element.name == "vertex") facets_.points.push_back(p);
    if (element.name == "face") facets_.add(std::move(polygon));
  }

  Words words_, header_;
  const std::string& content_;
  Bytes bytes_;
  std::string format_;
  std::vector<Element> elements_;
  Facets facets_;
};

Facets read_ply(const std::string& content) {
  return PlyReader(content).read();
}

Facets read_stl(const std::string& content) {
  // Binary files may begin with "solid" too.
  const bool is_text = boost::istarts_with(content, "solid") && boost::icontains(content, "facet") &&
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
  leave_out_single_group(facets);
  return facets;
}

}  // namespace

Facets read_facets(const std::string& content, const std::string& extension) {
  const std::map<std::string, Facets (*)(const std::string&)> readers{
      {".stl", read_stl}, {".obj", read_obj},  {".off", read_off},
      {".ply", read_ply}, {".msh", read_gmsh}, {".vtk", read_vtk}};
  if (extension == ".vtu" || extension == ".vtp" || extension == ".vtkhdf")
    fail(
        "is of a newer format of VTK; save it as .vtk in ASCII, with ParaView's Save Data or meshio convert");
  if (extension == ".step" || extension == ".stp" || extension == ".iges" || extension == ".igs" ||
      extension == ".brep")
    fail("holds curved faces; mesh them first, such as by gmsh -2 FILE -o body.msh");
  const auto reader = readers.find(extension);
  if (reader == readers.end())
    fail("has a name of no known format; give a file .stl, .obj, .off, .ply, .msh or .vtk");
  return reader->second(content);
}

}  // namespace crackle::solid
