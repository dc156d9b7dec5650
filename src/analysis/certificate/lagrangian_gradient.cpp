#include "analysis/certificate/lagrangian_gradient.hpp"

#include "analysis/certificate/small_products.hpp"

namespace conddp {

LagrangianGradient lagrangian_gradient(const ShootingProblem& problem,
                                       const std::vector<NodeDerivatives>& derivatives,
                                       const Eigen::MatrixXd& costates,
                                       const Eigen::VectorXd& multipliers) {
  const int N = problem.knots(), ndx = problem.ndx();
  LagrangianGradient out{-costates, {}, costates.cwiseAbs(), {}};
  NodeGradient node;
  for (int k = 0; k <= N; ++k) {
    node_gradient(problem, derivatives[k], k, multipliers,
                  k < N ? costates.col(k + 1).data() : nullptr, node);
    if (k < N) {
      out.control.emplace_back(node.value.tail(problem.nu(k)));
      out.control_size.emplace_back(node.size.tail(problem.nu(k)));
    }
    out.state.col(k) += node.value.head(ndx);
    out.state_size.col(k) += node.size.head(ndx);
  }
  return out;
}

void node_gradient(const ShootingProblem& problem, const NodeDerivatives& derivatives, int node,
                   const Eigen::VectorXd& multipliers, const double* next, NodeGradient& out) {
  out.value = derivatives.cost;
  out.size = derivatives.cost.cwiseAbs();
  add_transposed_product(derivatives.constraint,
                         multipliers.data() + problem.constraint_offset(node), out.value, out.size);
  if (next != nullptr) add_transposed_product(derivatives.step, next, out.value, out.size);
}

}  // namespace conddp
