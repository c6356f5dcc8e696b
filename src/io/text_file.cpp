// SPDX-License-Identifier: GPL-3.0-or-later
#include "crackle/io/text_file.h"

#include "partial_file.h"

#include <fmt/format.h>
#include <unistd.h>

#include <span>

namespace crackle::io {

void write_text_file(const std::filesystem::path& file, const std::string& text) {
  // Runs of other ranges of samples may write the same file.
  PartialFile partial(file, fmt::format(".{}", ::getpid()));
  partial.write(std::as_bytes(std::span(text)));
  partial.commit();
}

}  // namespace crackle::io
