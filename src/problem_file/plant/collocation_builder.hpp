#pragma once

#include "ocp/problem/problem.hpp"
#include "problem_file/plant/plant.hpp"

namespace conddp {

/// Replaces the plant's systems, except its jumps, by collocation systems if the integrator is a
/// collocation rule. Returns false with an error if collocation is not supported.
bool collocate(const ProblemSpec& spec, Plant& plant, Diagnostics& out);

/// Adds the equations of the steps of a collocation system as the last constraint, `collocation`.
/// Call after setting the model's free duration.
void add_collocation_terms(KnotModel& model);
/// Writes the constraint's numbers into the parameters of a knot.
void write_collocation_parameters(const KnotModel& model, double dt, double* parameters);

/// Initial guess of the slopes of each step, from its state and actuators and the next state. The
/// slopes are those at the stages of the Hermite-Simpson cubic through both states. They satisfy
/// the constraint if the step reaches the next state.
void guess_slopes(const ShootingProblem& problem, Trajectory& trajectory);

}  // namespace conddp
