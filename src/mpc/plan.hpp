#pragma once

#include <functional>
#include <vector>

#include "mpc/time_line.hpp"
#include "ocp/evaluation/evaluator.hpp"

namespace conddp {

/// An answer as a function of time: states between nodes along the shortest way on the manifold,
/// controls and gains held over a knot. Before the first node and after the last one it is what it
/// is there. A remembered control is within a knot the knot's own.
struct Plan {
  /// For answers of this problem, which has to outlive it.
  explicit Plan(const ShootingProblem& problem);

  const ShootingProblem* problem;
  std::vector<double> times;  ///< of its nodes, s
  Trajectory trajectory;
  Feedback feedback;
  Eigen::VectorXd multipliers;  ///< of all constraint rows

  /// The knot that takes time and contains a time, or is nearest to it.
  int knot_at(double time) const;
  /// Writes the state at a time, between nodes on the straight way. At an instant (impulse) the one
  /// after it or, with `before`, the one before it. `tangent` is scratch of ndx numbers.
  void state_at(double time, bool before, double* tangent, double* x) const;
};

/// A state that is held by the controls u + K (x ⊖ x̄) within their bounds, whatever control was
/// applied last.
struct HeldState {
  std::vector<double> x;  ///< x̄
  Eigen::VectorXd u;
  Eigen::MatrixXd K;  ///< nu x ndx
  /// Moves x̄ near a state, from which it is held from then on; null: x̄ stays.
  std::function<void(const double* x, std::vector<double>& held)> settle = nullptr;
};

/// Scratch of control laws.
struct PolicyScratch {
  explicit PolicyScratch(const ShootingProblem& problem)
      : x(problem.nx()), tangent(problem.ndx()) {}
  std::vector<double> x, tangent;
};

/// Moves a control to the nearest one within the bounds of a model.
void clip_control(const KnotModel& model, Eigen::VectorXd& u);

/// The control of a plan at a time, within its bounds: u_k.
void planned_control(const Plan& plan, double time, Eigen::VectorXd& u);
/// The same with gains, u_k + K_k (x ⊖ x̄) at a state, where x̄ is the one that the plan has at the
/// time. A remembered control counts where a knot begins.
void control_of(const Plan& plan, double time, const double* planned, const double* x,
                PolicyScratch& scratch, Eigen::VectorXd& u);
/// The control that holds a state, within the bounds of the model.
void control_of(const HeldState& held, const KnotModel& model, const double* x,
                PolicyScratch& scratch, Eigen::VectorXd& u);

}  // namespace conddp
