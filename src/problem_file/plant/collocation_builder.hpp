#pragma once

#include "ocp/problem/problem.hpp"
#include "problem_file/plant/plant.hpp"

namespace conddp {

/// Makes the plant's systems those of collocation where the integrator asks for it, all but its
/// jumps. False where that cannot be, which is reported.
bool collocate(const ProblemSpec& spec, Plant& plant, Diagnostics& out);

/// Adds what the steps of a collocation system obey, as the last constraint, `collocation`. After
/// the model's free duration.
void add_collocation_terms(KnotModel& model);
/// Writes its numbers into the parameters of a knot.
void write_collocation_parameters(const KnotModel& model, double dt, double* parameters);

/// The slopes of each step, from its state and actuators and the next state, at the stages of the
/// curve through both states (a cubic of Hermite and Simpson's): they obey the constraint where the
/// step meets the next state.
void guess_slopes(const ShootingProblem& problem, Trajectory& trajectory);

}  // namespace conddp
