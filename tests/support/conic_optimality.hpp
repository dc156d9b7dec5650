#pragma once

#include <string_view>
#include <vector>

#include "solvers/strategies/registry.hpp"
#include "support/conic_problems.hpp"

/// Optimality checks of answers to random conic problems, from their matrices only.
namespace conddp::testing {

/// From zeros with tight tolerances.
SolveResult solve_strictly(const ConicLinearQuadratic& conic, std::string_view solver);

/// Largest difference of controls.
double control_distance(const SolveResult& a, const SolveResult& b);

/// Largest violation of the optimality conditions, which are sufficient here: dynamics,
/// constraints, signs and complementarity of multipliers, and the control gradient with
/// independently computed costates.
double optimality_error(const ConicLinearQuadratic& conic, const SolveResult& result);

/// Solves with each solver: answers are optimal and agree to 1e-7.
std::vector<SolveResult> expect_agreement(const ConicLinearQuadratic& conic,
                                          const std::vector<const char*>& solvers);

/// Expects a solution or a status that explains the failure, never non-finite numbers.
void expect_answer(const ConicLinearQuadratic& conic, const char* solver);

}  // namespace conddp::testing
