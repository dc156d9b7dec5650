#pragma once

#include <vector>

#include "ocp/problem/problem.hpp"

namespace conddp {

/// New multipliers from s = g + ν/ρ for values g and the augmented Lagrangian with penalty ρ and
/// multipliers ν: ρ (s − Π(s)), limited for soft constraints. Both arrays have c.term->rows
/// numbers.
void next_multipliers(const NodeConstraint& c, const double* s, double penalty, double* next);

/// Violation of a constraint by g: 0 if soft, else distance_to_set.
double violation(const NodeConstraint& c, const double* g);
/// Complementarity of the term. For a soft constraint outside its set: the distance times the
/// amount by which the multipliers fall short of their limit.
double complementarity(const NodeConstraint& c, const double* g, const double* multipliers);

/// Cost of all l1-soft constraints, from the values of all rows. An evaluation counts l2-soft
/// constraints as costs.
double linear_soft_cost(const ShootingProblem& problem, const Eigen::VectorXd& values);

}  // namespace conddp
