// SPDX-License-Identifier: GPL-3.0-or-later
// The headers for a program that links the library: it reads an input, computes its samples and reads their
// results.
#pragma once

#include "analysis/statistics.h"
#include "ensemble/run.h"
#include "input/reader.h"
#include "io/ensemble_file.h"
#include "io/sample_file.h"
#include "parallel/communicator.h"
