// SPDX-License-Identifier: GPL-3.0-or-later
// The input reader under libFuzzer: any bytes either give parameters that can be echoed, or an InputError
// with messages of one printable line each. tools/fuzz-input builds and runs it.
#include "input/reader.h"

#include <cstddef>
#include <cstdint>
#include <cstdlib>
#include <string>

namespace {

/// Starts with the file name, and fits a terminal.
bool is_sound(const std::string& message) {
  if (message.rfind("fuzz.toml:", 0) != 0 || message.size() > 700) return false;
  for (const char c : message) {
    if (static_cast<unsigned char>(c) < 0x20 || c == 0x7f) return false;
  }
  return true;
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace crackle::input;
  try {
    const Parameters parameters = parse({reinterpret_cast<const char*>(data), size}, "fuzz.toml");
    if (echo(parameters).empty() || sample_identity(parameters).empty()) std::abort();
  } catch (const InputError& error) {
    if (error.messages().empty()) std::abort();
    for (const std::string& message : error.messages()) {
      if (!is_sound(message)) std::abort();
    }
  }
  return 0;
}
