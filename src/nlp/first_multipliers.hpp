#pragma once

#include <optional>

#include "nlp/nonlinear_program.hpp"
#include "nlp/symmetric_factorization.hpp"

namespace conddp {

/// Multipliers of a program's rows at its current point with the least Σ weight_i (∂L/∂y_i)², plus
/// the squared distances of inequality multipliers from 1. Bounds of variables have multipliers of
/// 1. `weights`: positive, by variable. Empty if derivatives are not finite, or the rows do not
/// determine the multipliers.
std::optional<Eigen::VectorXd> first_multipliers(NonlinearProgram& program,
                                                 const Eigen::VectorXd& weights,
                                                 MakeFactorization make_factorization);

}  // namespace conddp
