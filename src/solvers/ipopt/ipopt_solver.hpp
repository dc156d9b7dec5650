#pragma once

#include <chrono>
#include <memory>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "nlp/interior_point.hpp"
#include "nlp/transcription.hpp"
#include "solvers/common/control_bounds.hpp"
#include "solvers/common/options.hpp"
#include "solvers/common/solve_result.hpp"
#include "solvers/constraints/projected_newton.hpp"
#include "solvers/ipopt/answer_choice.hpp"
#include "solvers/ipopt/hessian_alternation.hpp"

namespace conddp {

/// How Ipopt's systems are factorized along the horizon: by a ChainFactorization where constraints
/// have at most twice as many rows as knots have directions. Each row adds unknowns to a group of
/// the chain, which is dense there; where there are more inequalities these are eliminated before
/// (InequalityElimination). Null, for Ipopt's own linear solver, where there are more equalities.
MakeFactorization factorization_along_horizon(const ShootingProblem& problem);

/// Direct transcription: the whole problem as a sparse nonlinear program for Ipopt, whose answer a
/// few steps of Newton's method on its active set take from the interior to the bounds.
///
/// Complementary pairs are relaxed, and a sequence of solves tightens them, each from the last
/// one's answer; the last solve has the smaller one of each pair fixed to zero
/// (ipopt_relaxation.cpp).
class IpoptSolver {
 public:
  IpoptSolver(const ShootingProblem& problem, const SolverOptions& options);

  SolveResult solve(const Trajectory& guess);

 private:
  /// Why the callback stopped Ipopt.
  enum class Stop { none, recenter, time_limit, interrupted, cost_settled };
  /// On the active set, at most.
  static constexpr int kNewtonSteps = 10;

  void reset();
  Trajectory start_from(const Trajectory& guess);
  void start_with_multipliers(const Eigen::VectorXd& y, InteriorPointSettings& settings,
                              PrimalDualPoint& first);
  InteriorPointAnswer run_ipopt(Eigen::VectorXd y, InteriorPointSettings settings);
  InteriorPointSettings default_settings() const;
  void make_transcription(PairRelaxation relaxation);

  // ipopt_relaxation.cpp
  InteriorPointAnswer run_relaxations(const Trajectory& start);
  struct Tightening;
  InteriorPointAnswer tighten(const Trajectory& start, double initial, int iterations);
  std::optional<InteriorPointAnswer> end_tightening(double epsilon,
                                                    const InteriorPointAnswer& answer,
                                                    Tightening& so_far);
  std::optional<InteriorPointAnswer> try_early_polish(double epsilon,
                                                      const InteriorPointAnswer& answer,
                                                      Tightening& so_far);
  InteriorPointAnswer relax_and_run(double epsilon, const Eigen::VectorXd& y,
                                    InteriorPointSettings& settings);
  std::optional<InteriorPointAnswer> try_polish(InteriorPointAnswer answer);
  InteriorPointAnswer polished_or(InteriorPointAnswer good, InteriorPointAnswer failed);
  bool is_out_of_budget() const;
  bool polish(InteriorPointAnswer& answer, bool trial);
  std::vector<InteriorPointAnswer> solve_fixed(const InteriorPointAnswer& answer, bool trial);
  InteriorPointSettings polish_settings(std::size_t solve, bool trial) const;
  double cost_at(const InteriorPointAnswer& answer);
  InteriorPointAnswer run_polish(const PrimalDualPoint& from,
                                 const InteriorPointSettings& settings);
  bool crosses_over(const InteriorPointAnswer& polished);
  void cross_over_from_polished(const InteriorPointAnswer& polished);
  bool is_as_asked(const IterationRecord& last) const;
  bool is_complementary(const InteriorPointAnswer& answer) const;

  // ipopt_cross_over.cpp
  /// Multiplier over distance of control bounds and constraint rows; 0 where there is none.
  struct BoundRatios {
    Trajectory lower, upper;
    Eigen::VectorXd rows;
  };
  BoundRatios bound_ratios(const InteriorPointAnswer& answer, const Trajectory& trajectory,
                           const Eigen::VectorXd& multipliers) const;
  Eigen::VectorXd row_ratios(const Eigen::VectorXd& multipliers) const;
  void compare_ratios(BoundRatios ratios, bool goes_on);
  void snap_controls(const InteriorPointAnswer& answer, Trajectory& trajectory) const;
  Feedback find_gains(const Trajectory& trajectory, const Eigen::VectorXd& multipliers);
  void cross_over(const InteriorPointAnswer& answer, bool goes_on = false);
  Eigen::VectorXd multipliers_of(const InteriorPointAnswer& answer) const;
  void take_newton_steps();
  void start_newton(const Trajectory& trajectory, const Eigen::VectorXd& multipliers);
  void refine(InteriorPointAnswer& answer);
  void sweep_at_answer();

  bool alternation_pays() const;
  bool knows_multipliers() const;
  bool newton_is_enough(const Trajectory& start);
  bool note(const InteriorPointIterate& iterate);
  void keep_if_best(const InteriorPointIterate& iterate, bool again);
  void alternate_hessians(const InteriorPointIterate& iterate, bool again);
  void describe(const InteriorPointIterate& iterate);
  Stop reason_to_stop(const InteriorPointIterate& iterate) const;
  bool leaves_chart(const InteriorPointIterate& iterate) const;
  void record();
  void note_newton_step();
  void consider(bool preferred = false);
  void write_result();
  void write_values();
  IterationRecord* row_of_answer();
  void log_answer();
  void set_status(const InteriorPointAnswer& answer);
  using Ending = std::pair<SolveStatus, std::string>;
  Ending find_status(const InteriorPointAnswer& answer) const;
  std::optional<Ending> stopped_status() const;
  bool iterations_used_up(const InteriorPointAnswer& answer) const;
  bool start_violates_constraint() const;
  bool cost_settled() const;
  bool under_tolerances(const KktNorms& norms) const;
  std::string residual_text() const;
  double elapsed() const;

  const ShootingProblem& problem_;
  SolverOptions options_;
  bool gauss_newton_;
  bool alternates_ = false;  ///< between exact and Gauss-Newton Hessians
  HessianAlternation alternation_;
  ControlBounds bounds_;
  Evaluator evaluator_;
  std::unique_ptr<Transcription> transcription_;
  ProjectedNewton newton_;
  Stop stop_ = Stop::none;
  AnswerChoice choice_;         ///< the answer so far is the result
  IterationRecord answer_row_;  ///< its row of the log
  /// Polished answers with larger barriers than the one that is crossed over from first, from the
  /// largest one on.
  std::vector<InteriorPointAnswer> looser_;
  bool crossed_over_ = false;  ///< nothing is left to cross over from
  int iterations_before_ = 0;  ///< of earlier runs of Ipopt in this solve
  IterationRecord row_;
  /// The best iterate: that of the least optimality error, which is the largest of gap, violation,
  /// dual infeasibility and complementarity.
  Eigen::VectorXd best_;
  double best_error_ = 0;
  /// Of constraint rows: by what multipliers are compared with distances from a bound.
  Eigen::VectorXd penalty_;
  /// Of the sweep that gave the gains of Newton's iterate, if one did.
  std::optional<double> gain_regularization_;
  BoundRatios former_;  ///< of the last answer that was crossed over from
  /// Where Ipopt went on from the answer before: the means of both answers' ratios.
  std::optional<BoundRatios> scales_;
  SolveResult result_;
  std::chrono::steady_clock::time_point began_;
};

}  // namespace conddp
