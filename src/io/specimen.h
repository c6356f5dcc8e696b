// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "crackle/geometry/body.h"
#include "hdf5.h"

namespace crackle::io {

/// Writes the group /specimen: the members of geometry::for_each_member, for those who draw the body.
void write_specimen(hid_t file, const geometry::Body& body);

}  // namespace crackle::io
