#pragma once

#include <functional>
#include <vector>

#include "mpc/time_line.hpp"
#include "ocp/evaluation/evaluator.hpp"

namespace conddp {

/// An answer as a function of time. States between nodes follow the shortest path on the manifold;
/// controls and gains are constant over a knot. Before the first node and after the last, values
/// stay constant. Within a knot, a remembered control is the knot's own control.
struct Plan {
  /// Plan for answers of this problem, which must outlive it.
  explicit Plan(const ShootingProblem& problem);

  const ShootingProblem* problem;
  std::vector<double> times;  ///< of the nodes, s
  Trajectory trajectory;
  Feedback feedback;
  Eigen::VectorXd multipliers;  ///< of all constraint rows

  /// Knot that takes time and contains `time`, or the nearest such knot.
  int knot_at(double time) const;
  /// Writes the state at a time, interpolated between nodes. At an instant (impulse), this is the
  /// state after it or, with `before`, the state before it. `tangent` is scratch of ndx numbers.
  void state_at(double time, bool before, double* tangent, double* x) const;
};

/// A state held by the controls u + K (x ⊖ x̄), clipped to their bounds. They are independent of
/// the control applied last.
struct HeldState {
  std::vector<double> x;  ///< x̄
  Eigen::VectorXd u;
  Eigen::MatrixXd K;  ///< nu x ndx
  /// Moves x̄ near the state x, where holding begins; null keeps x̄.
  std::function<void(const double* x, std::vector<double>& held)> settle = nullptr;
};

/// Scratch memory of control laws.
struct PolicyScratch {
  explicit PolicyScratch(const ShootingProblem& problem)
      : x(problem.nx()), tangent(problem.ndx()) {}
  std::vector<double> x, tangent;
};

/// Clips a control to the bounds of a model.
void clip_control(const KnotModel& model, Eigen::VectorXd& u);

/// Control u_k of a plan at a time, clipped to its bounds.
void planned_control(const Plan& plan, double time, Eigen::VectorXd& u);
/// Control u_k + K_k (x ⊖ x̄) at a state, clipped to its bounds; x̄ is `planned`, the plan's state
/// at the time. A remembered control enters only at the start of a knot.
void control_of(const Plan& plan, double time, const double* planned, const double* x,
                PolicyScratch& scratch, Eigen::VectorXd& u);
/// Control that holds a state, clipped to the bounds of the model.
void control_of(const HeldState& held, const KnotModel& model, const double* x,
                PolicyScratch& scratch, Eigen::VectorXd& u);

/// Cost and violation of following a plan through a window, by the window's own problem.
struct TrialFigures {
  double violation = 0;  ///< largest violation of a hard constraint; infinite if the motion
                         ///< diverges
  double cost = 0;
};

/// True if the violation is smaller by more than a tolerance, or equal within it and the cost is
/// smaller.
bool is_better(const TrialFigures& a, const TrialFigures& b, double tolerance);

/// Rolls out plans through a window from its initial state, with their controls and gains, clipped
/// to the control bounds. This makes plans comparable that violate constraints or have gaps.
class PlanTrial {
 public:
  /// Problem of a window, which must outlive the trial.
  explicit PlanTrial(const ShootingProblem& window);

  /// `plan` has the window's shape. Its first state may differ from the window's where the gains of
  /// its first knot act.
  TrialFigures follow(const Trajectory& plan, const Feedback& feedback);

 private:
  Evaluator evaluator_;
  SingleRollout rollout_;
  Evaluation evaluation_;
};

}  // namespace conddp
