#pragma once

#include "ocp/problem/problem.hpp"
#include "problem_file/plant/plant.hpp"

namespace conddp {

/// A half-space, sphere or box that a candidate may touch, carried by a frame (−1: the world).
decltype(ContactCandidate::against) touched_form(const TouchedSpec& touched, int frame);

/// The system of a contact-implicit problem, around its robots; what cannot be
/// is reported.
std::shared_ptr<const SteppingSystem> build_stepping(const ProblemSpec& spec, const Plant& plant,
                                                     Diagnostics& out);

/// Warns where a state (nx numbers) has bodies overlap that cannot: a first step throws them apart.
void warn_of_overlaps(const ProblemSpec& spec, const Plant& plant, const std::vector<double>& state,
                      Diagnostics& out);

/// Adds the equations of a step, its complementary pairs and the regularisation of its forces, by
/// the names `stepping`, `complementarity` and `contact_regularization`, as the last terms.
void add_stepping_terms(const std::shared_ptr<const SteppingSystem>& system, KnotModel& model);
/// Writes their numbers into the parameters of a knot.
void write_stepping_parameters(const KnotModel& model, double dt, double regularization,
                               double* parameters);

}  // namespace conddp
