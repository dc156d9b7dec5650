#include <algorithm>
#include <vector>

#include "solvers/linalg/cholesky.hpp"
#include "solvers/stages/box_qp.hpp"
#include "solvers/stages/stage_solver.hpp"
#include "solvers/stages/stage_sweep.hpp"

namespace conddp {
namespace {

class BoxStage : public StageSolver {
 public:
  BoxStage(const ShootingProblem& problem, int max_nu, int segments)
      : StageSolver(ActiveSet(problem)) {
    const int rows = segments > 1 ? parametric_rows(problem) : problem.ndx();
    scratch_.reserve(segments);
    for (int segment = 0; segment < segments; ++segment) scratch_.emplace_back(rows, max_nu);
  }

  bool solve(const StageProblem& stage, Eigen::Ref<Eigen::VectorXd> k,
             const LaneBlock& Kt) override {
    active_set().bound(stage);
    const bool bounded = active_set().holds_any(stage.knot);
    if (bounded)
      return active_set().is_held() ? solve_held(stage, k, Kt) : solve_in_box(stage, k, Kt);
    // Most knots are far from every bound; there the free minimum also solves the QP.
    const bool solved = stage.solve_free(scratch_[stage.segment].factor, k, Kt);
    if (active_set().is_held() || (solved && is_within_bounds(stage.knot, k))) return solved;
    return solve_in_box(stage, k, Kt);
  }

 private:
  /// Workspace of one stage.
  struct Scratch {
    Scratch(int rows, int max_nu)
        : qp(max_nu), factor(max_nu, max_nu), rhs(rows + 1, max_nu), before(max_nu) {
      free.reserve(max_nu);
    }
    BoxQp qp;
    LaneMatrix factor, rhs;
    std::vector<BoundState> before;
    std::vector<int> free;
  };

  bool is_within_bounds(int knot, const Eigen::Ref<const Eigen::VectorXd>& k) {
    return (k.array() >= active_set().lower(knot).array()).all() &&
           (k.array() <= active_set().upper(knot).array()).all();
  }

  /// Minimizes the stage between its bounds, starting from the active set of the previous sweep.
  bool solve_in_box(const StageProblem& stage, Eigen::Ref<Eigen::VectorXd> k, const LaneBlock& Kt) {
    const int nu = static_cast<int>(k.size());
    Scratch& scratch = scratch_[stage.segment];
    const std::span<BoundState> active = active_set().states(stage.knot);
    std::copy(active.begin(), active.end(), scratch.before.begin());
    if (scratch.qp.solve(stage.Quu, stage.Qu, active_set().lower(stage.knot),
                         active_set().upper(stage.knot),
                         active) == BoxQp::Status::not_positive_definite)
      return false;
    k = scratch.qp.x();
    // Feedback acts only on the free controls: K_f = −Q_ff⁻¹ Q_fx.
    const auto free = scratch.qp.free();
    const int count = static_cast<int>(free.size());
    scratch.rhs.resize(Kt.rows, count);
    for (int j = 0; j < count; ++j) stage.negate(free[j], scratch.rhs.block(), j);
    solve_rows_in_place(scratch.qp.free_factor(), scratch.rhs.block());
    Kt.view().setZero();
    for (int j = 0; j < count; ++j) Kt.view().col(free[j]) = scratch.rhs.view().col(j);
    int changes = 0;
    for (int i = 0; i < nu; ++i) changes += active[i] != scratch.before[i];
    active_set().count_changes(changes);
    if (count < nu) active_set().remember(stage);
    return true;
  }

  /// Puts the held entries (at least one) at their bounds and lists the others.
  void hold_entries(int knot, Eigen::Ref<Eigen::VectorXd> k, std::vector<int>& free) {
    const std::span<const BoundState> active = active_set().states(knot);
    free.clear();
    for (int i = 0; i < k.size(); ++i) {
      if (active[i] == BoundState::free)
        free.push_back(i);
      else
        k[i] = (active[i] == BoundState::at_lower ? active_set().lower(knot)
                                                  : active_set().upper(knot))[i];
    }
  }

  /// Loads the block of the free entries, and right-hand sides whose gradient includes the held
  /// entries.
  void load_free(const StageProblem& stage, const Eigen::Ref<const Eigen::VectorXd>& k,
                 Scratch& scratch) {
    const std::vector<int>& free = scratch.free;
    const int count = static_cast<int>(free.size());
    auto factor = scratch.factor.view();
    const LaneBlock solution = scratch.rhs.block();
    auto rhs = solution.view();
    const int gradient = solution.rows - 1;
    for (int a = 0; a < count; ++a) {
      for (int b = a; b < count; ++b) factor(b, a) = stage.Quu(free[b], free[a]);
      stage.negate(free[a], solution, a);
      for (int i = 0; i < k.size(); ++i)
        if (active_set().holds(stage.knot, i)) rhs(gradient, a) -= stage.Quu(i, free[a]) * k[i];
    }
  }

  /// Minimizes the stage with the held entries fixed at their bounds.
  bool solve_held(const StageProblem& stage, Eigen::Ref<Eigen::VectorXd> k, const LaneBlock& Kt) {
    const int rows = Kt.rows - 1;
    Scratch& scratch = scratch_[stage.segment];
    std::vector<int>& free = scratch.free;
    hold_entries(stage.knot, k, free);
    const int count = static_cast<int>(free.size());
    scratch.factor.resize(count, count);
    // One solve serves both: the gradient is an additional row of right-hand sides.
    scratch.rhs.resize(rows + 1, count);
    const LaneBlock solution = scratch.rhs.block();
    auto rhs = solution.view();
    load_free(stage, k, scratch);
    if (!cholesky_in_place(scratch.factor.block())) return false;
    solve_rows_in_place(scratch.factor.block(), solution);
    for (int a = 0; a < count; ++a) k[free[a]] = rhs(rows, a);
    Kt.view().setZero();
    for (int a = 0; a < count; ++a) Kt.view().col(free[a]) = rhs.col(a);
    active_set().remember(stage);
    return true;
  }

  std::vector<Scratch> scratch_;  ///< one per segment
};

}  // namespace

std::unique_ptr<StageSolver> box_stage(const ShootingProblem& problem, int segments) {
  return std::make_unique<BoxStage>(problem, largest_nu(problem), segments);
}

}  // namespace conddp
