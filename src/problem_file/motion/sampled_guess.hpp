#pragma once

#include <string>

#include "ocp/problem/problem.hpp"
#include "problem_file/data/time_series.hpp"
#include "problem_file/plant/plant.hpp"

namespace conddp {

/// The values at any time of `nodes` splines over evenly spaced nodes, each of which is 1 at its
/// own node and 0 at the others.
TimeSeries unit_splines(int nodes, Interpolation interpolation, double first, double last);

/// Replaces the guess by the best rollout of controls around it (`initial_guess: {sampling: ...}`).
/// The guess stays, with its states, if no rollout is better than that of its own controls. False,
/// with an error, if the splines have more nodes than there are knots with controls.
///
/// Controls of one name are one channel through all phases. A choice without time, such as a free
/// duration, is a channel of one number, if it has bounds. Steps of contact-implicit problems are
/// those of a simulator that solves each of them.
///
/// `states` and `controls` describe the sources of the guess, for the output.
bool sample_guess(const ProblemSpec& spec, const Plant& plant, const ShootingProblem& problem,
                  Trajectory& guess, std::string& states, std::string& controls, Diagnostics& out);

}  // namespace conddp
