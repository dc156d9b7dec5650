#pragma once

#include "ocp/problem/problem.hpp"
#include "problem_file/plant/plant.hpp"

namespace conddp {

/// A half-space, sphere or box that a candidate may touch, on a frame (−1: the world).
decltype(ContactCandidate::against) touched_form(const TouchedSpec& touched, int frame);

/// The system of a contact-implicit problem with its robots; unsupported input is reported.
std::shared_ptr<const SteppingSystem> build_stepping(const ProblemSpec& spec, const Plant& plant,
                                                     Diagnostics& out);

/// Warns of rigid candidates that overlap in a state (nx numbers): the first step would push them
/// apart.
void warn_of_overlaps(const ProblemSpec& spec, const Plant& plant, const std::vector<double>& state,
                      Diagnostics& out);

/// Adds the equations of a step, its complementarity pairs and the regularization of its forces as
/// the last terms, named `stepping`, `complementarity` and `contact_regularization`.
void add_stepping_terms(const std::shared_ptr<const SteppingSystem>& system, KnotModel& model);
/// Writes the numbers of these terms into the parameters of a knot.
void write_stepping_parameters(const KnotModel& model, double dt, double regularization,
                               double* parameters);

}  // namespace conddp
