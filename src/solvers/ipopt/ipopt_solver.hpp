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
#include "solvers/constraints/answer_choice.hpp"
#include "solvers/constraints/projected_newton.hpp"
#include "solvers/ipopt/hessian_alternation.hpp"

namespace conddp {

/// Factorization of Ipopt's systems along the horizon. It is a ChainFactorization if constraints
/// have at most twice as many rows as knots have directions: each row adds unknowns to a group of
/// the chain, which is dense there. If inequalities exceed this number, they are eliminated first
/// (InequalityElimination). If equalities do, it is null, for Ipopt's own linear solver.
MakeFactorization factorization_along_horizon(const ShootingProblem& problem);

/// Direct transcription: the whole problem becomes a sparse nonlinear program for Ipopt. A few
/// active-set Newton steps then move the answer from the interior onto its bounds.
///
/// Complementary pairs are relaxed. A sequence of solves tightens them, each from the previous
/// answer; the last solve fixes the smaller variable of each pair to zero (ipopt_relaxation.cpp).
class IpoptSolver {
 public:
  IpoptSolver(const ShootingProblem& problem, const SolverOptions& options);

  SolveResult solve(const Trajectory& guess);

 private:
  /// Reason why the callback stopped Ipopt.
  enum class Stop { none, recenter, time_limit, interrupted, cost_settled };

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
  /// Multiplier over distance, for control bounds and constraint rows; 0 without a bound.
  struct BoundRatios {
    Trajectory lower, upper;
    Eigen::VectorXd rows;
  };
  BoundRatios bound_ratios(const InteriorPointAnswer& answer, const Trajectory& trajectory,
                           const Eigen::VectorXd& multipliers) const;
  Eigen::VectorXd row_ratios(const Eigen::VectorXd& multipliers) const;
  void compare_ratios(BoundRatios ratios, bool goes_on);
  void snap_controls(const InteriorPointAnswer& answer, Trajectory& trajectory) const;
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
  bool alternates_ = false;  ///< alternates between exact and Gauss-Newton Hessians
  HessianAlternation alternation_;
  ControlBounds bounds_;
  Evaluator evaluator_;
  std::unique_ptr<Transcription> transcription_;
  ProjectedNewton newton_;
  Stop stop_ = Stop::none;
  AnswerChoice choice_;         ///< its answer so far is the result
  IterationRecord answer_row_;  ///< row of the log that describes it
  /// Polished answers with larger barriers than the first one to cross over from, the largest
  /// barrier first.
  std::vector<InteriorPointAnswer> looser_;
  bool crossed_over_ = false;  ///< the crossover is already done
  int iterations_before_ = 0;  ///< iterations of earlier Ipopt runs in this solve
  IterationRecord row_;
  /// Iterate with the least optimality error, which is the largest of gap, violation, dual
  /// infeasibility and complementarity.
  Eigen::VectorXd best_;
  double best_error_ = 0;
  /// By constraint row: factor that compares multipliers with distances from a bound.
  /// Regularization of the sweep that gave the gains of the Newton iterate, if any.
  std::optional<double> gain_regularization_;
  BoundRatios former_;  ///< of the last answer to cross over from
  /// Geometric means of the ratios of two answers, if Ipopt continued from the previous one.
  std::optional<BoundRatios> scales_;
  SolveResult result_;
  std::chrono::steady_clock::time_point began_;
};

}  // namespace conddp
