// SPDX-License-Identifier: GPL-3.0-or-later
// What a program that links the library includes: an input is read, its samples are computed, their results
// are read.
#pragma once

#include "analysis/statistics.h"
#include "ensemble/run.h"
#include "input/reader.h"
#include "io/ensemble_file.h"
#include "io/sample_file.h"
#include "parallel/communicator.h"
