#include "analysis/derivatives/node_hessians.hpp"

#include "ocp/evaluation/evaluator.hpp"

namespace conddp {
std::vector<Eigen::MatrixXd> hessians_of(const Linearization& model) {
  std::vector<Eigen::MatrixXd> list;
  list.reserve(model.knots.size());
  for (const KnotLinearization& knot : model.knots) list.push_back(knot.hessian());
  return list;
}

std::vector<Eigen::MatrixXd> gauss_newton_hessians(const ShootingProblem& problem,
                                                   const Trajectory& trajectory) {
  Linearization model(problem);
  Evaluator(problem).differentiate(trajectory, model);
  return hessians_of(model);
}

std::vector<Eigen::MatrixXd> exact_hessians(const ShootingProblem& problem,
                                            const Trajectory& trajectory,
                                            const Eigen::MatrixXd& costates,
                                            const Augmentation* augmentation) {
  Evaluator evaluator(problem);
  Linearization model(problem);
  evaluator.differentiate(trajectory, model, augmentation);
  evaluator.lagrangian_hessian(trajectory, costates, model, augmentation);
  return hessians_of(model);
}

}  // namespace conddp
