// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "document.h"
#include "findings.h"

#include <array>
#include <string>
#include <string_view>

namespace crackle::input {

/// A key that was called otherwise in version 1.0.0; both names are full paths in the same table.
struct RenamedKey {
  std::string_view earlier;
  std::string_view current;
};

/// Both names are accepted until the next version.
inline constexpr std::array renamed_keys{RenamedKey{"mesh.turn", "mesh.symmetry"},
                                         RenamedKey{"fracture.memory", "fracture.accumulation"}};

/// The current name of a key; notes it, at this place of the input, if the name has changed.
std::string current_name(const std::string& key, const std::string& place, int line, Findings& findings);

/// "earlier = value" of a line "current = value"; other lines unchanged. For identities, which must be those
/// of version 1.0.0.
std::string with_earlier_name(std::string line);

/// The text with the current names of all keys. Notes each earlier name; reports one given along with the
/// current name, and removes it from `root`.
/// @param root the parsed text; updated to the result
std::string with_current_names(std::string text, Value& root, Findings& findings);

}  // namespace crackle::input
