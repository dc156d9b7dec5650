#pragma once

#include <functional>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "solvers/common/options.hpp"
#include "solvers/common/solve_result.hpp"

namespace conddp {

/// What a solver does with control bounds.
enum class BoundSupport {
  exact,    ///< keeps them and converges to a constrained optimum
  clipped,  ///< keeps them by cutting controls off, which may end short of an optimum
  none,     ///< does not support them
};

/// Which constraints, besides bounds on the control, a solver keeps.
enum class ConstraintSupport { none, equalities, all };

/// A solver of the family: what it is called, what it can, and how to run it.
struct SolverInfo {
  std::string_view name;
  std::string_view description;  ///< one line
  BoundSupport control_bounds = BoundSupport::none;
  ConstraintSupport constraints = ConstraintSupport::none;
  bool complementarity = false;      ///< keeps 0 ≤ z ⊥ s ≥ 0
  bool open_gaps = false;            ///< starts from states that do not follow from the controls
  bool gauss_newton_hessian = true;  ///< can leave the dynamics' second derivatives out
  bool exact_hessian = false;        ///< can use them
  bool segments = false;             ///< can sweep the horizon by segments
  bool concurrent = true;            ///< may run in several threads at once
  /// The solver alone: where it ends as `infeasible` that is a suspicion, which solve() looks into.
  std::function<SolveResult(const ShootingProblem&, const SolverOptions&, const Trajectory& guess)>
      run = {};
};

/// All solvers, in the order in which documents list them.
std::span<const SolverInfo> solvers();
/// The solver of this name, or null.
const SolverInfo* find_solver(std::string_view name);
/// The names of the constraints, but bounds on the control, that the solver does not support, each
/// once, in the order of the nodes.
std::vector<std::string> unsupported_constraints(const SolverInfo& solver,
                                                 const ShootingProblem& problem);
/// Why the solver cannot take the problem: the constraint, and the solvers that can. Empty if it
/// can.
std::optional<std::string> unsupported(const SolverInfo& solver, const ShootingProblem& problem);

/// Why the solver does not have the Hessian of the dynamics that is chosen. Empty if it has.
std::optional<std::string> unsupported_hessian(const SolverInfo& solver, HessianChoice choice);

/// Why the solver cannot sweep the problem's horizon in so many segments. Empty if it can.
std::optional<std::string> unsupported_segments(const SolverInfo& solver,
                                                const ShootingProblem& problem, int segments);

/// Stands for a choice by the problem.
inline constexpr std::string_view kAutoSolver = "auto";
/// What `auto` tries, one after the other: ipopt alone where pairs are complementary; altro,
/// proxddp and ipopt where there are constraints besides bounds on the control; else box_fddp and
/// ipopt. Of these, solvers that take the Hessian and the segments asked for.
std::vector<const SolverInfo*> auto_solvers(const ShootingProblem& problem,
                                            const SolverOptions& options);

using SolverList = std::span<const SolverInfo* const>;
/// Which of them `auto` begins with, why, and which ones follow: "altro, since there are
/// constraints besides bounds on the control; then proxddp, ipopt".
std::string describe_auto(const ShootingProblem& problem, SolverList list);

/// Solves a problem from a guess, along a homotopy and with restarts where the options ask for
/// them. Throws std::invalid_argument where the options are not valid, the solver refuses the
/// problem, the segments or the Hessian asked for, or the guess has another shape; every other end
/// is a status.
SolveResult solve(const ShootingProblem& problem, const SolverInfo& solver,
                  const SolverOptions& options, const Trajectory& guess);
/// What speaks against an answer that converged.
struct Objection {
  std::string text;    ///< empty: nothing
  bool jumps = false;  ///< the motion leads through what it should go around
  double excess = 0;   ///< how many times as much is left to gain as may be; 0: that is not it
  /// At a saddle (δx, δu) of each node, along which the cost falls; else empty.
  std::vector<Eigen::VectorXd> descent;
};
/// Finds an objection. May be called by several threads.
using Doubt = std::function<Objection(const ShootingProblem&, const SolveResult&)>;
/// By the first of these whose answer converges and raises no doubt (solve_answering), all within
/// one time limit; null: there are none. Where all of several fail, by the first of them from up to
/// 20 other guesses, without a homotopy; else the answer of the first. After an end by a limit or a
/// signal no other follows. `used` ← whose answer it is; multipliers to start from go to those that
/// take some. Throws std::invalid_argument where there is none.
SolveResult solve(const ShootingProblem& problem, SolverList candidates,
                  const SolverOptions& options, const Trajectory& guess, const SolverInfo*& used,
                  const Doubt& doubt = nullptr);
/// The same, and where the answer came soon the best of further ones (look_further).
SolveResult solve_best(const ShootingProblem& problem, SolverList candidates,
                       const SolverOptions& options, const Trajectory& guess,
                       const SolverInfo*& used, const Doubt& doubt);
/// The same by name, `auto` included; an unknown name is a std::invalid_argument.
SolveResult solve(const ShootingProblem& problem, std::string_view solver,
                  const SolverOptions& options, const Trajectory& guess);

}  // namespace conddp
