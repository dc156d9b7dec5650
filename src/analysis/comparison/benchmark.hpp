#pragma once

#include <limits>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include <Eigen/Core>

#include "ocp/problem/trajectory.hpp"
#include "solvers/strategies/registry.hpp"

namespace conddp {

class ShootingProblem;

/// Quality of a trajectory as an answer, found from the trajectory itself. Figures that cannot be
/// evaluated are NaN.
struct AnswerCheck {
  double cost = std::numeric_limits<double>::quiet_NaN();
  /// max ‖f(x_k, u_k) ⊖ x_{k+1}‖∞, or the distance of x_0 from the initial state if that is larger.
  double gap = std::numeric_limits<double>::quiet_NaN();
  /// ‖∇_u L‖∞ over the entries that no bound balances.
  double stationarity = std::numeric_limits<double>::quiet_NaN();
  /// Largest violation of a control bound or distance of a constraint from its set.
  double constraint = std::numeric_limits<double>::quiet_NaN();
  /// Largest product of a multiplier and the distance from its bound.
  double complementarity = std::numeric_limits<double>::quiet_NaN();
};

/// Measures the answers of all solvers alike, whatever they report about themselves.
///
/// Multipliers come from an adjoint pass along the trajectory with a policy computed here:
///   λ_N = ∇ℓ_N,  ∇_u L = ℓ_u + f_uᵀ λ_{k+1},  λ_k = ℓ_x + f_xᵀ λ_{k+1} + Kᵀ ∇_u L.
/// The gains K are those of a plain Riccati recursion on the Gauss-Newton model of the trajectory.
/// ∇_u L vanishes at the same trajectories for all K, but without feedback, rounding grows as an
/// unstable motion does. A control within `bound_tolerance`·max(1, |bound|) of a bound that the
/// descent direction would cross counts for complementarity instead of stationarity.
///
/// Constraints other than control bounds have further multipliers ν, which a trajectory alone does
/// not determine. They are taken from the answer, one number per constraint row; without them,
/// stationarity and complementarity are NaN. L then includes the terms νᵀg.
AnswerCheck check_answer(const ShootingProblem& problem, const Trajectory& trajectory,
                         double bound_tolerance = 1e-6,
                         const Eigen::VectorXd& constraint_multipliers = {});

/// Measurements of a solver on a problem.
struct BenchmarkRun {
  std::string solver;
  std::string status;   ///< status of the solve, or "refused"
  std::string message;  ///< reason of the status
  int iterations = 0;
  /// Backward passes, or equation systems in methods without passes: at least one per iteration.
  int sweeps = 0;
  AnswerCheck check;          ///< result of check_answer
  Residuals claimed;          ///< residuals that the solver reports
  bool solved = false;        ///< converged, and the check agrees
  SolveTimes median;          ///< medians over the timed solves, part by part, s
  std::vector<double> times;  ///< total of each timed solve, s; empty if refused

  /// (largest − smallest) / median of the times.
  double spread() const;
  /// False if a solver reports convergence that the check does not confirm.
  bool kept_word() const { return solved || status != to_string(SolveStatus::converged); }
};

/// Repetition of a timed solve.
struct Repetition {
  int count = 0;  ///< solves after a warm-up; 0: the warm-up itself is timed
  /// A solve that took longer is not repeated, s.
  double longest_s = std::numeric_limits<double>::infinity();
};

/// The check confirms a reported residual up to this multiple of its tolerance. Stationarity along
/// another policy is a different number.
inline constexpr double kCheckFactor = 10;

/// Solves with the first of several solvers that converges: once to warm up, then as often as
/// `repetition` says against the clock, one after the other. `name` is the solver name of the run.
/// If the warm-up hits the time limit or may not be repeated, its own time counts. If the problem
/// or an option is refused, the run has that status. `answer`, if given, receives the trajectory
/// found.
BenchmarkRun run_benchmark(const ShootingProblem& problem, const Trajectory& guess,
                           std::string_view name, SolverList solvers, const SolverOptions& options,
                           const Repetition& repetition, Trajectory* answer = nullptr);
/// The same for the solver of the given name, including `auto`.
BenchmarkRun run_benchmark(const ShootingProblem& problem, const Trajectory& guess,
                           std::string_view solver, const SolverOptions& options,
                           const Repetition& repetition, Trajectory* answer = nullptr);

/// Median of some numbers (mean of the middle two for an even count); NaN if empty.
double median(std::vector<double> values);

/// Share of a set of problems that a solver solves within τ. For a performance profile, τ is a
/// multiple of the best solver's effort (Dolan, Moré 2002); for a data profile, it is an effort
/// (Moré, Wild 2009).
struct PerformanceProfile {
  std::string solver;
  /// (τ, share) at each rise of the share, in ascending order of τ; empty if no problem is solved.
  std::vector<std::pair<double, double>> steps;

  /// Share at τ.
  double share(double tau) const;
};

/// `effort[p][s]`: effort of solver s for problem p (time, iterations), infinite if it did not
/// solve it. If the best effort is 0, solvers with 0 have the ratio 1 and all others have 1 plus
/// their effort.
std::vector<PerformanceProfile> performance_profiles(
    const std::vector<std::string>& solvers, const std::vector<std::vector<double>>& effort);

/// The same for the effort itself, without comparison. A unit that is independent of the machine
/// and other solvers, such as backward sweeps, makes profiles of different runs comparable.
std::vector<PerformanceProfile> data_profiles(const std::vector<std::string>& solvers,
                                              const std::vector<std::vector<double>>& effort);

}  // namespace conddp
