// SPDX-License-Identifier: GPL-3.0-or-later
// The input reader under libFuzzer: any bytes either give parameters whose echo can be made, or an InputError with
// messages. tools/fuzz-input builds and runs it.
#include "crackle/input/reader.h"

#include <cstddef>
#include <cstdint>
#include <cstdlib>
#include <string>

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace crackle::input;
  try {
    const Parameters parameters = parse({reinterpret_cast<const char*>(data), size}, "fuzz.toml");
    if (echo(parameters).empty() || sample_identity(parameters).empty()) std::abort();
  } catch (const InputError& error) {
    if (error.messages().empty()) std::abort();
  }
  return 0;
}
