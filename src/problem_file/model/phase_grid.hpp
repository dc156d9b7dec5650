#pragma once

#include "problem_file/model/spec.hpp"

namespace conddp {

/// Step lengths of a phase as multiples of its regular step `dt`.
std::vector<double> relative_steps(const PhaseSpec& phase);
/// Step lengths of a phase, s; 0 for an impulse.
std::vector<double> phase_steps(const PhaseSpec& phase);
/// Sum of these steps, s.
double phase_duration(const PhaseSpec& phase);

}  // namespace conddp
