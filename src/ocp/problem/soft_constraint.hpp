#pragma once

#include <vector>

#include "ocp/problem/problem.hpp"

namespace conddp {

/// Multipliers of values g that the augmented Lagrangian with penalty ρ and multipliers ν gives,
/// from s = g + ν/ρ: ρ (s − Π(s)), within the limits of a soft constraint. Both of c.term->rows.
void next_multipliers(const NodeConstraint& c, const double* s, double penalty, double* next);

/// How far g is from where it has to be: 0 of soft constraints, else distance_to_set.
double violation(const NodeConstraint& c, const double* g);
/// As of its term; of a soft constraint, outside of its set, the distance times what the
/// multipliers lack of their limit.
double complementarity(const NodeConstraint& c, const double* g, const double* multipliers);

/// What all constraints that are soft by their distance cost, from the values of all rows. Those by
/// a square are among the costs of an evaluation.
double linear_soft_cost(const ShootingProblem& problem, const Eigen::VectorXd& values);

}  // namespace conddp
