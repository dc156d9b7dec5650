#include "analysis/certificate/solution_claims.hpp"

namespace conddp {

SolutionClaims::SolutionClaims(const ShootingProblem& problem)
    : trajectory(problem.create_trajectory()),
      costates(Eigen::MatrixXd::Zero(problem.ndx(), problem.knots() + 1)),
      state_gradient(Eigen::MatrixXd::Zero(problem.ndx(), problem.knots() + 1)),
      multipliers(Eigen::VectorXd::Zero(problem.constraint_rows())) {
  for (int k = 0; k < problem.knots(); ++k) {
    lower_multipliers.emplace_back(Eigen::VectorXd::Zero(problem.nu(k)));
    upper_multipliers.emplace_back(Eigen::VectorXd::Zero(problem.nu(k)));
    feedforward.emplace_back(Eigen::VectorXd::Zero(problem.nu(k)));
    gains.emplace_back(Eigen::MatrixXd::Zero(problem.nu(k), problem.ndx()));
  }
}

}  // namespace conddp
