#include "solvers/globalization/direction.hpp"

#include "solvers/stages/stage_solver.hpp"

namespace conddp {

Direction::Direction(const ShootingProblem& problem, const ControlBounds& bounds,
                     const Recipe& recipe)
    : bounds_(bounds),
      qp_(problem, bounds, make_stages(problem, recipe), recipe.box_stage, recipe.clamp_controls),
      lbfgs_(bounds) {}

std::unique_ptr<StageSolver> Direction::make_stages(const ShootingProblem& problem,
                                                    const Recipe& recipe) {
  if (!recipe.null_space)
    return recipe.box_stage ? box_stage(problem) : unconstrained_stage(problem);
  auto stages = std::make_unique<NullSpaceStage>(problem);
  null_space_ = stages.get();
  return stages;
}

void Direction::correct(const Linearization& linearization, const Trajectory& trajectory,
                        const Gaps& gaps) {
  if (!qp_.within_bounds()) {
    forget_steps();
    return;
  }
  lbfgs_.observe(feedback(), qp_.last_sweep(), qp_.active_set());
  corrected_ = lbfgs_.correct(qp_.feedback());
  if (!corrected_) return;
  qp_.roll(linearization, trajectory, gaps);
  if (step_violates_bounds(trajectory)) undo_correction(linearization, trajectory, gaps);
}

/// True for a violation at a control that the active set leaves free.
bool Direction::step_violates_bounds(const Trajectory& trajectory) const {
  for (int k = 0; k < bounds_.knots(); ++k) {
    const auto u = trajectory.u(k);
    const auto du = step().du(k);
    for (int i = 0; i < du.size(); ++i) {
      if (qp_.active_set().holds(k, i)) continue;
      if (u[i] + du[i] < bounds_.lower(k)[i] || u[i] + du[i] > bounds_.upper(k)[i]) return true;
    }
  }
  return false;
}

void Direction::undo_correction(const Linearization& linearization, const Trajectory& trajectory,
                                const Gaps& gaps) {
  lbfgs_.restore(qp_.feedback());
  forget_steps();
  qp_.roll(linearization, trajectory, gaps);
}

void Direction::forget_steps() {
  lbfgs_.clear();
  corrected_ = false;
}

void Direction::reset(int sweeps) {
  forget_steps();
  qp_.reset(sweeps);
}

}  // namespace conddp
