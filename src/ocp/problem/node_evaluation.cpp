#include "ocp/problem/node_evaluation.hpp"

namespace conddp {

KnotInput<double> NodeEvaluation::input(int node, const double* x, const double* u) const {
  const KnotView& view = problem_.knot(node);
  return {x, u, view.parameters, view.dt, view.cost_scale};
}

KnotWorkspace<double>& NodeEvaluation::workspace(const KnotModel& model) {
  auto& work = work_[&model];
  if (!work) work = std::make_unique<KnotWorkspace<double>>(model);
  return *work;
}

const KnotWorkspace<double>& NodeEvaluation::at(int node, const double* x, const double* u) {
  const KnotModel& model = *problem_.knot(node).model;
  KnotWorkspace<double>& work = workspace(model);
  model.evaluate(input(node, x, u), work);
  return work;
}

const KnotWorkspace<double>& NodeEvaluation::derivatives_at(int node, const double* x,
                                                            const double* u) {
  const KnotModel& model = *problem_.knot(node).model;
  KnotWorkspace<double>& work = workspace(model);
  model.differentiate(input(node, x, u), work, false);
  return work;
}

const KnotWorkspace<double>& NodeEvaluation::at(int node, const Trajectory& trajectory) {
  const double* u = node < problem_.knots() ? trajectory.u(node).data() : nullptr;
  return at(node, trajectory.x(node).data(), u);
}

}  // namespace conddp
