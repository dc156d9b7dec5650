#pragma once

#include <memory>
#include <vector>

#include "ocp/evaluation/linearization.hpp"
#include "ocp/evaluation/rollout_options.hpp"

namespace conddp {

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
  Eigen::VectorXd augmentation;  ///< N + 1: what constraints add to it
  Eigen::VectorXd constraint;    ///< g, all constraint rows of the problem
};

/// kLaneWidth trajectories rolled out at once, one per step length.
struct LaneRollout {
  explicit LaneRollout(const ShootingProblem& problem);
  Lane cost;              ///< with the augmentation
  AlignedVector<Lane> x;  ///< (N + 1) x nx
  AlignedVector<Lane> u;  ///< controls of all knots, one after the other
  /// The knot at which a lane's state or cost stopped being finite, −1 where all is finite.
  int first_bad_knot[kLaneWidth];
  /// Copies one lane's trajectory.
  void extract(int lane, Trajectory& trajectory) const;
};

/// One trajectory rolled out alone.
struct SingleRollout {
  explicit SingleRollout(const ShootingProblem& problem)
      : trajectory(problem.create_trajectory()) {}
  double cost = 0;  ///< with the augmentation
  Trajectory trajectory;
  int first_bad_knot = -1;  ///< as in LaneRollout
};

class EvaluationMemory;

/// The few functions through which solvers evaluate a problem. After construction (and
/// reserve_lagrangian_hessian, for that one) none of them allocates. Knots of one
/// structure share lanes, from whichever phases. Results do not depend on the number of threads.
class Evaluator {
 public:
  explicit Evaluator(const ShootingProblem& problem, int threads = 1);
  /// With workspaces and threads that it shares with evaluators of other problems, of which none
  /// is in use at the same time.
  Evaluator(const ShootingProblem& problem, std::shared_ptr<EvaluationMemory> memory);
  ~Evaluator();
  Evaluator(const Evaluator&) = delete;
  Evaluator& operator=(const Evaluator&) = delete;

  const ShootingProblem& problem() const { return problem_; }

  /// Gaps, costs and constraint values of a trajectory. Here and below an augmentation is added
  /// to the cost where there is one.
  void evaluate(const Trajectory& trajectory, Evaluation& out,
                const Augmentation* augmentation = nullptr);
  /// First derivatives and Gauss-Newton Hessians.
  void differentiate(const Trajectory& trajectory, Linearization& out,
                     const Augmentation* augmentation = nullptr);
  /// Allocates what lagrangian_hessian needs, for callers that may want it later. Not `by_parts`,
  /// Hessians come from dual numbers through all of `differentiate`: the reference for those
  /// that KnotSecondDerivatives knows in less time. The first call decides.
  void reserve_lagrangian_hessian(bool by_parts = true);
  /// Replaces the Hessians of `out` by the exact ones of the cost + Σ λ_{k+1}ᵀ f(x_k, u_k), with
  /// co-states λ (ndx x (N + 1), column k belongs to node k), exact to second order on manifolds.
  void lagrangian_hessian(const Trajectory& trajectory, const Eigen::MatrixXd& costates,
                          Linearization& out, const Augmentation* augmentation = nullptr);
  /// Rolls out u = ū + α k + K (x ⊖ x̄) around `reference` for a step length α in each lane,
  /// from x_0 = the problem's initial state. `gap` is that of the reference.
  void roll_out(const Trajectory& reference, const Eigen::MatrixXd& gap, const Feedback& feedback,
                const double* step_lengths, const RolloutOptions& options, LaneRollout& out);
  /// The same for a single step length, in less time. A lane's numbers are the same up to rounding.
  void roll_out(const Trajectory& reference, const Eigen::MatrixXd& gap, const Feedback& feedback,
                double step_length, const RolloutOptions& options, SingleRollout& out);
  /// Simulates the trajectory's controls from the initial state, overwriting its states; clamps
  /// the controls first if asked. Returns the first knot with a non-finite result, or −1.
  int simulate(Trajectory& trajectory, bool clamp_controls = false);

 private:
  struct Impl;
  const ShootingProblem& problem_;
  std::unique_ptr<Impl> impl_;
};

}  // namespace conddp
