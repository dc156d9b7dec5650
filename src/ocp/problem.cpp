#include "ocp/problem.hpp"

#include <stdexcept>

namespace conddp {
namespace {

void check(const Phase& phase) {
  const std::size_t n = phase.dt.size();
  if (!phase.model || n == 0 || phase.cost_scale.size() != n ||
      phase.parameters.size() != n * phase.model->parameter_count())
    throw std::invalid_argument("phase " + phase.name + ": sizes do not fit its model");
}

}  // namespace

ShootingProblem::ShootingProblem(std::vector<double> initial_state, std::vector<Phase> phases,
                                 Phase terminal)
    : initial_state_(std::move(initial_state)),
      phases_(std::move(phases)),
      terminal_(std::move(terminal)) {
  check(terminal_);
  if (terminal_.model->integrator() != Integrator::none || terminal_.knots() != 1)
    throw std::invalid_argument("the terminal phase is one node without dynamics");
  double time = 0;
  for (int p = 0; p <= static_cast<int>(phases_.size()); ++p) {
    const Phase& phase = p < static_cast<int>(phases_.size()) ? phases_[p] : terminal_;
    check(phase);
    if (phase.model->nx() != terminal_.model->nx() || phase.model->ndx() != terminal_.model->ndx())
      throw std::invalid_argument("phase " + phase.name + " has another state than the terminal");
    for (int k = 0; k < phase.knots(); ++k) {
      views_.push_back({phase.model.get(),
                        phase.parameters.data() + k * phase.model->parameter_count(), phase.dt[k],
                        phase.cost_scale[k], p});
      times_.push_back(time);
      time += phase.dt[k];
    }
  }
  if (static_cast<int>(initial_state_.size()) != nx())
    throw std::invalid_argument("the initial state has the wrong size");
}

bool ShootingProblem::has_control_bounds() const {
  for (const Phase& phase : phases_)
    if (phase.model->has_control_bounds()) return true;
  return false;
}

Trajectory ShootingProblem::create_trajectory() const {
  std::vector<int> sizes(knots());
  for (int k = 0; k < knots(); ++k) sizes[k] = nu(k);
  Trajectory trajectory(nx(), sizes);
  const Eigen::Map<const Eigen::VectorXd> x0(initial_state_.data(), nx());
  for (int k = 0; k <= knots(); ++k) trajectory.x(k) = x0;
  return trajectory;
}

}  // namespace conddp
