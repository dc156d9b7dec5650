#pragma once

#include <optional>

#include "nlp/nonlinear_program.hpp"
#include "nlp/symmetric_factorization.hpp"

namespace conddp {

/// Multipliers of a program's rows at its present point with the least Σ weight_i (∂L/∂y_i)², where
/// bounds of variables have multipliers of 1, plus the squares of what multipliers of inequalities
/// lie from 1. `weights`: positive, one a variable. Nothing where derivatives are not finite, or
/// the rows do not determine them.
std::optional<Eigen::VectorXd> first_multipliers(NonlinearProgram& program,
                                                 const Eigen::VectorXd& weights,
                                                 MakeFactorization make_factorization);

}  // namespace conddp
