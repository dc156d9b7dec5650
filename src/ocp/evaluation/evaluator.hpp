#pragma once

#include <memory>
#include <vector>

#include "ocp/evaluation/linearization.hpp"
#include "ocp/problem/problem.hpp"

namespace conddp {

/// Treatment of gaps and bounds in a rollout.
struct RolloutOptions {
  bool contract_gaps = false;   ///< x_{k+1} = f ⊕ (α − 1) gap instead of f (multiple shooting)
  bool clamp_controls = false;  ///< clamp every control to its bounds
  const Augmentation* augmentation = nullptr;  ///< added to the cost
};

/// Feedforward and feedback of a control update δu = α k + K δx, one per knot.
struct Feedback {
  explicit Feedback(const ShootingProblem& problem);
  std::vector<Eigen::VectorXd> k;  ///< nu
  std::vector<Eigen::MatrixXd> K;  ///< nu x ndx

  void set_zero();
};

/// Result of evaluating a trajectory knot by knot.
struct Evaluation {
  explicit Evaluation(const ShootingProblem& problem);
  Eigen::MatrixXd gap;           ///< ndx x N: f(x_k, u_k) ⊖ x_{k+1}
  Eigen::VectorXd cost;          ///< N + 1
  Eigen::VectorXd augmentation;  ///< N + 1: contribution of the constraints to the cost
  Eigen::VectorXd constraint;    ///< g, all constraint rows of the problem
};

/// kLaneWidth simultaneous rollouts, one per step length.
struct LaneRollout {
  explicit LaneRollout(const ShootingProblem& problem);
  Lane cost;              ///< augmentation included
  AlignedVector<Lane> x;  ///< (N + 1) x nx
  AlignedVector<Lane> u;  ///< controls of all knots, one after the other
  /// First knot at which a lane's state or cost is not finite, −1 if all are finite.
  int first_bad_knot[kLaneWidth];
  /// Copies one lane's trajectory.
  void extract(int lane, Trajectory& trajectory) const;
};

/// A single rollout.
struct SingleRollout {
  explicit SingleRollout(const ShootingProblem& problem)
      : trajectory(problem.create_trajectory()) {}
  double cost = 0;  ///< augmentation included
  Trajectory trajectory;
  int first_bad_knot = -1;  ///< as in LaneRollout
};

class EvaluationMemory;

/// Functions through which solvers evaluate a problem. None of them allocates after construction;
/// lagrangian_hessian needs reserve_lagrangian_hessian for this. Knots of the same structure share
/// lanes across phases. Results do not depend on the number of threads.
class Evaluator {
 public:
  explicit Evaluator(const ShootingProblem& problem, int threads = 1);
  /// Shares workspaces and threads with evaluators of other problems; only one of them may be in
  /// use at a time.
  Evaluator(const ShootingProblem& problem, std::shared_ptr<EvaluationMemory> memory);
  ~Evaluator();
  Evaluator(const Evaluator&) = delete;
  Evaluator& operator=(const Evaluator&) = delete;

  const ShootingProblem& problem() const { return problem_; }

  /// Evaluates gaps, costs and constraint values of a trajectory. Here and below, an augmentation,
  /// if given, is added to the cost.
  void evaluate(const Trajectory& trajectory, Evaluation& out,
                const Augmentation* augmentation = nullptr);
  /// First derivatives and Gauss-Newton Hessians.
  void differentiate(const Trajectory& trajectory, Linearization& out,
                     const Augmentation* augmentation = nullptr);
  /// Allocates the workspaces of lagrangian_hessian ahead of its first call. Without `by_parts`,
  /// Hessians come from dual numbers through all of `differentiate`: a reference for
  /// KnotSecondDerivatives, which computes them faster. The first call decides.
  void reserve_lagrangian_hessian(bool by_parts = true);
  /// Replaces the Hessians of `out` by the exact Hessians of the cost + Σ λ_{k+1}ᵀ f(x_k, u_k),
  /// with co-states λ (ndx x (N + 1), column k belongs to node k). They are exact to second order
  /// on manifolds.
  void lagrangian_hessian(const Trajectory& trajectory, const Eigen::MatrixXd& costates,
                          Linearization& out, const Augmentation* augmentation = nullptr);
  /// Rolls out u = ū + α k + K (x ⊖ x̄) around `reference` with one step length α per lane, from
  /// the problem's initial state x_0. `gap` holds the gaps of the reference.
  void roll_out(const Trajectory& reference, const Eigen::MatrixXd& gap, const Feedback& feedback,
                const double* step_lengths, const RolloutOptions& options, LaneRollout& out);
  /// Rolls out a single step length faster. The numbers agree with those of a lane up to rounding.
  void roll_out(const Trajectory& reference, const Eigen::MatrixXd& gap, const Feedback& feedback,
                double step_length, const RolloutOptions& options, SingleRollout& out);
  /// Simulates the trajectory's controls from the initial state and overwrites its states; clamps
  /// the controls first if requested. Returns the first knot with a non-finite result, or −1.
  int simulate(Trajectory& trajectory, bool clamp_controls = false);

 private:
  struct Impl;
  const ShootingProblem& problem_;
  std::unique_ptr<Impl> impl_;
};

}  // namespace conddp
