#pragma once

#include <memory>
#include <optional>
#include <vector>

#include "ocp/evaluation/evaluation_memory.hpp"
#include "ocp/evaluation/evaluator.hpp"
#include "solvers/common/control_bounds.hpp"
#include "solvers/common/options.hpp"
#include "solvers/common/solve_record.hpp"
#include "solvers/constraints/projected_newton.hpp"
#include "solvers/interior/filter.hpp"
#include "solvers/interior/interior_terms.hpp"
#include "solvers/riccati/adjoint.hpp"
#include "solvers/riccati/backward_sweep.hpp"
#include "solvers/riccati/linear_rollout.hpp"
#include "solvers/stages/stage_solver.hpp"

namespace conddp {

/// Primal-dual interior-point method (Wächter, Biegler 2006) over multiple shooting, whose linear
/// algebra is a Riccati sweep: InteriorTerms condenses the constraints into the nodes. A filter
/// accepts steps. Hessians are exact; a knot whose exact Hessian leaves its stage without a minimum
/// takes the Gauss-Newton one. A few Newton steps on the active constraints end the solve.
///
/// With complementary pairs, the first relaxation ε decides between local optima, and whether the
/// solve succeeds. Failed solves are repeated from the guess with a smaller one.
class InteriorSolver {
 public:
  /// `memory` may be shared with solvers that never solve at the same time; null creates its own.
  InteriorSolver(const ShootingProblem& problem, const SolverOptions& options,
                 std::shared_ptr<EvaluationMemory> memory = nullptr);

  SolveResult solve(const Trajectory& guess);
  /// A real-time iteration: takes as many steps as the options allow iterations, from a guess and
  /// the multipliers of the options, with one barrier and the relaxation
  /// `complementarity.initial`. Pairs stay relaxed, so that gains see contacts that are open
  /// (Le Cleac'h et al. 2024). The last iterate is not linearized: the gains are those of the sweep
  /// that led to it. The answer stays valid until the next one; allocates nothing.
  const SolveResult& iterate(const Trajectory& guess);
  /// Swaps the gains of that answer into `to`, which has their shape.
  void take_feedback(Feedback& to) { std::swap(record_.result.feedback, to); }

 private:
  /// How a solve begins: barrier, relaxation of pairs, and distance of the first iterate from its
  /// bounds.
  struct Start {
    double barrier, relaxation, inside;
  };
  void solve_relaxed(const Trajectory& guess, double relaxation, int last_iteration);
  void start(const Trajectory& guess, const Start& how);
  void end_iterated();
  bool run_iteration(int last_iteration);
  bool linearize();
  bool end_diverged();
  void measure();
  bool barrier_solved() const;
  bool lower_barrier();
  bool cost_settled();
  bool step();
  void form_hessians();
  bool find_direction();
  bool sweep_exact();
  bool sweep_convex();
  bool search();
  std::pair<double, double> judge(double length, const Trajectory& trial);
  bool try_length(double length);
  void end_by_newton();
  void keep_answer();
  void choose_answer();
  std::optional<double> sweep_at_answer();
  void write_result();
  SolveResult judge_guess(const Trajectory& guess);
  void take_guess(const Trajectory& guess);
  bool out_of_budget() const;
  double infeasibility(const Eigen::MatrixXd& gap, const TermPoint& at) const;

  const ShootingProblem& problem_;
  SolverOptions options_;
  ControlBounds bounds_;
  Evaluator evaluator_;
  SolveRecord record_;
  InteriorTerms terms_;
  Filter filter_;
  Linearization linearization_;
  Evaluation evaluation_;  ///< of trial_
  Adjoint adjoint_;
  Gaps gaps_;
  BackwardSweep sweep_;
  std::unique_ptr<StageSolver> stages_;
  LinearRollout rollout_;
  Feedback feedback_;
  Augmentation lagrangian_;  ///< multipliers only
  Trajectory trajectory_, trial_;
  Trajectory answer_;  ///< best iterate of Newton's method
  SingleRollout rolled_;
  ProjectedNewton newton_;
  Eigen::VectorXd dx_, multipliers_, answer_multipliers_, penalty_;
  std::vector<Eigen::VectorXd> gradient_;        ///< of the Lagrangian, by node
  std::vector<Eigen::MatrixXd> convex_, exact_;  ///< Hessians by node, with all terms
  std::vector<bool> is_exact_;                   ///< of the Hessian that a node uses
  bool linear_costs_;
  StepLimits limits_;
  double excess_ = 0;               ///< of the answer's norms, in multiples of their tolerances
  double slope_ = 0;                ///< of the barrier function along the step
  std::pair<double, double> here_;  ///< θ and φ of the iterate
  double size_ = 1;                 ///< of multipliers, in hundreds
  int gauss_newton_ = 0;            ///< iterations with one barrier before exact Hessians
  int since_ = 0;                   ///< iterations with the present barrier
  bool use_exact_ = true;           ///< in the present iteration
  double last_barrier_ = 0;         ///< at which the iterations end
  bool settled_ = false;            ///< the last step would have changed θ and φ by rounding
  int short_steps_ = 0;             ///< in a row
  double weight_ = 0;               ///< regularization of the next sweeps
};

}  // namespace conddp
