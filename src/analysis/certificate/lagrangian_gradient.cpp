#include "analysis/certificate/lagrangian_gradient.hpp"

namespace conddp {

LagrangianGradient lagrangian_gradient(const ShootingProblem& problem,
                                       const std::vector<NodeDerivatives>& derivatives,
                                       const Eigen::MatrixXd& costates,
                                       const Eigen::VectorXd& multipliers) {
  const int N = problem.knots(), ndx = problem.ndx();
  LagrangianGradient out{-costates, {}, costates.cwiseAbs(), {}};
  for (int k = 0; k <= N; ++k) {
    const NodeGradient node = node_gradient(problem, derivatives[k], k, multipliers,
                                            k < N ? costates.col(k + 1) : Eigen::VectorXd());
    if (k < N) {
      out.control.emplace_back(node.value.tail(problem.nu(k)));
      out.control_size.emplace_back(node.size.tail(problem.nu(k)));
    }
    out.state.col(k) += node.value.head(ndx);
    out.state_size.col(k) += node.size.head(ndx);
  }
  return out;
}

NodeGradient node_gradient(const ShootingProblem& problem, const NodeDerivatives& derivatives,
                           int node, const Eigen::VectorXd& multipliers,
                           const Eigen::Ref<const Eigen::VectorXd>& next) {
  const NodeDerivatives& d = derivatives;
  const auto nu = multipliers.segment(problem.constraint_offset(node), d.constraint.rows());
  NodeGradient out{d.cost, d.cost.cwiseAbs()};
  out.value.noalias() += d.constraint.transpose() * nu;
  if (next.size() > 0) out.value.noalias() += d.step.transpose() * next;
  const Eigen::VectorXd nu_size = nu.cwiseAbs(), next_size = next.cwiseAbs();
  for (Eigen::Index i = 0; i < out.size.size(); ++i) {
    out.size[i] += d.constraint.col(i).cwiseAbs().dot(nu_size);
    if (next.size() > 0) out.size[i] += d.step.col(i).cwiseAbs().dot(next_size);
  }
  return out;
}

}  // namespace conddp
