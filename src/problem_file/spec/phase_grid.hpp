#pragma once

#include "problem_file/spec/spec.hpp"

namespace conddp {

/// Lengths of a phase's steps as multiples of its regular one, `dt`.
std::vector<double> relative_steps(const PhaseSpec& phase);
/// Lengths of a phase's steps, s; 0 of an impulse.
std::vector<double> phase_steps(const PhaseSpec& phase);
/// The sum of these steps, s.
double phase_duration(const PhaseSpec& phase);

}  // namespace conddp
