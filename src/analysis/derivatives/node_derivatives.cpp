#include "analysis/derivatives/node_derivatives.hpp"

#include <algorithm>

#include "spatial/lane.hpp"

namespace conddp {

NodeDerivatives derivatives_of_node(const ShootingProblem& problem, int node, MovingNodes& moving) {
  const KnotModel& model = *problem.knot(node).model;
  const bool running = node < problem.knots();
  const int nz = model.nz();
  NodeDerivatives out{Eigen::VectorXd(nz), Eigen::MatrixXd(model.constraint_rows(), nz),
                      running ? Eigen::MatrixXd(model.ndx(), nz) : Eigen::MatrixXd()};
  const Eigen::MatrixXd directions = Eigen::MatrixXd::Identity(nz, nz);
  for (int first = 0; first < nz; first += kLaneWidth) {
    const int count = std::min(kLaneWidth, nz - first);
    NodeMove moves[kLaneWidth];
    for (int i = 0; i < count; ++i) moves[i] = {node, directions.col(first + i).data()};
    moving.evaluate({moves, static_cast<std::size_t>(count)});
    for (int i = 0; i < count; ++i)
      moving.write(i, {&out.cost[first + i], out.constraint.col(first + i).data(),
                       running ? out.step.col(first + i).data() : nullptr});
  }
  return out;
}

std::vector<NodeDerivatives> node_derivatives(const ShootingProblem& problem,
                                              const Trajectory& trajectory,
                                              const Eigen::MatrixXd& gap) {
  MovingNodes moving(problem, trajectory, gap);
  std::vector<NodeDerivatives> all;
  for (int k = 0; k <= problem.knots(); ++k) all.push_back(derivatives_of_node(problem, k, moving));
  return all;
}

}  // namespace conddp
