#include "ocp/problem/node_evaluation.hpp"

namespace conddp {

const KnotWorkspace<double>& NodeEvaluation::at(int node, const double* x, const double* u) {
  const KnotView& view = problem_.knot(node);
  auto& work = work_[view.model];
  if (!work) work = std::make_unique<KnotWorkspace<double>>(*view.model);
  view.model->evaluate(KnotInput<double>{x, u, view.parameters, view.dt, view.cost_scale}, *work);
  return *work;
}

const KnotWorkspace<double>& NodeEvaluation::at(int node, const Trajectory& trajectory) {
  const double* u = node < problem_.knots() ? trajectory.u(node).data() : nullptr;
  return at(node, trajectory.x(node).data(), u);
}

}  // namespace conddp
