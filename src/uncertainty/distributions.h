// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "crackle/common/failure.h"
#include "crackle/input/parameters.h"

#include <mutex>
#include <openturns/Distribution.hxx>

/// OpenTURNS's part in random inputs.
namespace crackle::uncertainty {

/// The distribution of a random input's values [SI].
OT::Distribution distribution_of(const input::RandomInput& random);

/// One thread at a time is let into OpenTURNS.
std::mutex& openturns_mutex();

/// `work()` with OpenTURNS, whose errors become std::runtime_error.
template <class Work>
auto with_openturns(Work&& work) {
  const std::lock_guard lock(openturns_mutex());
  try {
    return work();
  } catch (const OT::Exception& error) {
    fail("OpenTURNS: {}", error.what());
  }
}

}  // namespace crackle::uncertainty
