// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "crackle/input/parameters.h"
#include "findings.h"

/// Contradictions between keys. Each check leaves out what depends on a key that is faulty itself.
namespace crackle::input {

/// Sides and planes nearer to each other than this part of the body's size count as touching.
inline constexpr double touching = 1e-6;

/// Whether the extent of the body can be judged.
bool size_is_known(const Findings& findings);

/// Whether the body is a box, with slots cut into its faces at most.
bool is_box(const Specimen& specimen);
/// Checks that the keys of the specimen go together, and finds the size of an outline and the shape of a body
/// that is no box. To be called before the checks.
void complete_specimen(Parameters& parameters, Findings& findings);

/// Finds the toughness that a stress intensity stands for, by Irwin in plane strain. To be called before the
/// checks.
void complete_fracture(Parameters& parameters, Findings& findings);

void check_specimen(const Parameters& parameters, Findings& findings);
void check_mesh(const Parameters& parameters, Findings& findings);
void check_sections(const Parameters& parameters, Findings& findings);
void check_fracture(const Parameters& parameters, Findings& findings);
void check_boundaries(const Parameters& parameters, Findings& findings);
void check_time(const Parameters& parameters, Findings& findings);
void check_output(const Parameters& parameters, Findings& findings);
void check_random(const Parameters& parameters, Findings& findings);
void check_sweeps(const Parameters& parameters, Findings& findings);

/// The kinds that a [[boundary]] in the file names; it should name one.
std::vector<std::string> kinds_given(const Findings& findings, const std::string& table);

}  // namespace crackle::input
