#include "nlp/interior_point.hpp"

#include <cmath>

namespace conddp {
namespace {

/// Force of bounds with unit multipliers: upwards from lower bounds, downwards from upper ones.
/// Equalities exert zero force.
Eigen::VectorXd force_of_bounds(const Eigen::VectorXd& lower, const Eigen::VectorXd& upper) {
  Eigen::VectorXd force = Eigen::VectorXd::Zero(lower.size());
  for (int i = 0; i < force.size(); ++i)
    if (lower[i] < upper[i]) force[i] = std::isfinite(lower[i]) - std::isfinite(upper[i]);
  return force;
}

}  // namespace

/// With the weights W, λ and r = W ∇L solve [W⁻¹ −Aᵀ; A 0] (r, λ) = (∇f, 0): the remaining r
/// satisfies A r = 0.
std::optional<Eigen::VectorXd> first_multipliers(NonlinearProgram& program,
                                                 const Eigen::VectorXd& weights,
                                                 MakeFactorization make_factorization) {
  constexpr double kPivotTolerance = 1e-6;
  const int variables = program.variables(), rows = program.rows();
  const Sparsity& jacobian = program.jacobian_structure();
  Sparsity system;
  for (int i = 0; i < variables + rows; ++i) system.add(i, i);
  for (int e = 0; e < jacobian.size(); ++e)
    system.add(variables + jacobian.rows[e], jacobian.columns[e]);
  Eigen::VectorXd values(system.size()), b = Eigen::VectorXd::Zero(variables + rows);
  program.gradient(b.data());
  program.jacobian(values.data() + variables + rows);
  if (!b.allFinite() || !values.tail(jacobian.size()).allFinite()) return std::nullopt;
  values.head(variables) = weights.cwiseInverse();
  b.head(variables) -= force_of_bounds(program.lower(), program.upper());
  b.tail(rows) -= force_of_bounds(program.row_lower(), program.row_upper());
  for (int row = 0; row < rows; ++row)
    values[variables + row] = program.row_lower()[row] < program.row_upper()[row] ? -1 : 0;
  const auto factorization = make_factorization();
  factorization->analyse(variables + rows, system.size(), system.rows.data(),
                         system.columns.data());
  if (factorization->factorize(values.data(), kPivotTolerance) !=
      SymmetricFactorization::Outcome::done)
    return std::nullopt;
  factorization->solve(b.data());
  Eigen::VectorXd multipliers = -b.tail(rows);
  if (!multipliers.allFinite()) return std::nullopt;
  return multipliers;
}

}  // namespace conddp
