// SPDX-License-Identifier: GPL-3.0-or-later
#include "crackle/io/text_file.h"

#include "partial_file.h"

#include <span>

namespace crackle::io {

void write_text_file(const std::filesystem::path& file, const std::string& text) {
  write_whole_file(file, std::as_bytes(std::span(text)));
}

}  // namespace crackle::io
