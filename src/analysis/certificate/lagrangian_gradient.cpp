#include "analysis/certificate/lagrangian_gradient.hpp"

namespace conddp {

LagrangianGradient lagrangian_gradient(const ShootingProblem& problem,
                                       const std::vector<NodeDerivatives>& derivatives,
                                       const Eigen::MatrixXd& costates,
                                       const Eigen::VectorXd& multipliers) {
  const int N = problem.knots(), ndx = problem.ndx();
  LagrangianGradient out{-costates, {}, costates.cwiseAbs(), {}};
  for (int k = 0; k <= N; ++k) {
    const NodeDerivatives& d = derivatives[k];
    const auto nu = multipliers.segment(problem.constraint_offset(k), d.constraint.rows());
    Eigen::VectorXd gradient = d.cost + d.constraint.transpose() * nu;
    Eigen::VectorXd size = d.cost.cwiseAbs() + d.constraint.cwiseAbs().transpose() * nu.cwiseAbs();
    if (k < N) {
      gradient += d.step.transpose() * costates.col(k + 1);
      size += d.step.cwiseAbs().transpose() * costates.col(k + 1).cwiseAbs();
      out.control.emplace_back(gradient.tail(problem.nu(k)));
      out.control_size.emplace_back(size.tail(problem.nu(k)));
    }
    out.state.col(k) += gradient.head(ndx);
    out.state_size.col(k) += size.head(ndx);
  }
  return out;
}

}  // namespace conddp
