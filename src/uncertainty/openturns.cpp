// SPDX-License-Identifier: GPL-3.0-or-later
#include "openturns.h"

#include "crackle/common/failure.h"

#include <dlfcn.h>

namespace crackle::uncertainty {

namespace {

/// Searched in the run path of the program.
const OpenTurns& load() {
  void* const module = dlopen(openturns_file, RTLD_NOW | RTLD_LOCAL);
  void* const entry = module ? dlsym(module, openturns_entry) : nullptr;
  if (!entry) fail("the part of crackle that draws random inputs cannot be loaded: {}", dlerror());
  return *reinterpret_cast<const OpenTurns* (*)()>(entry)();
}

}  // namespace

const OpenTurns& openturns() {
  static const OpenTurns& loaded = load();
  return loaded;
}

}  // namespace crackle::uncertainty
