#pragma once

#include <string_view>
#include <vector>

#include "solvers/strategies/registry.hpp"
#include "support/conic_problems.hpp"

/// Whether answers to random conic problems are optimal, from their matrices alone.
namespace conddp::testing {

/// From zeros, with tight tolerances.
SolveResult solve_strictly(const ConicLinearQuadratic& conic, std::string_view solver);

/// The largest difference of controls.
double control_distance(const SolveResult& a, const SolveResult& b);

/// The largest violation of the optimality conditions, which are sufficient here: dynamics,
/// constraints, signs and complementarity of multipliers, and the gradient by the controls with
/// co-states of this function's own.
double optimality_error(const ConicLinearQuadratic& conic, const SolveResult& result);

/// Solves by each of the solvers: answers are optimal, and the same to 1e-7.
std::vector<SolveResult> expect_agreement(const ConicLinearQuadratic& conic,
                                          const std::vector<const char*>& solvers);

/// A solution, or a status that says what is wrong; never numbers that are none.
void expect_answer(const ConicLinearQuadratic& conic, const char* solver);

}  // namespace conddp::testing
