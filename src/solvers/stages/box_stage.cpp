#include <algorithm>
#include <vector>

#include "solvers/linalg/cholesky.hpp"
#include "solvers/stages/box_qp.hpp"
#include "solvers/stages/stage_solver.hpp"

namespace conddp {
namespace {

class BoxStage : public StageSolver {
 public:
  BoxStage(const ShootingProblem& problem, int max_nu)
      : StageSolver(ActiveSet(problem)),
        qp_(max_nu),
        factor_(max_nu, max_nu),
        rhs_(problem.ndx() + 1, max_nu),
        before_(max_nu) {
    free_.reserve(max_nu);
  }

  bool solve(const StageProblem& stage, Eigen::Ref<Eigen::VectorXd> k,
             const LaneBlock& Kt) override {
    active_set().bound(stage);
    const bool bounded = active_set().holds_any(stage.knot);
    if (bounded)
      return active_set().is_held() ? solve_held(stage, k, Kt) : solve_in_box(stage, k, Kt);
    // Most knots are far from every bound; there the free minimum also solves the QP.
    const bool solved = stage.solve_free(factor_, k, Kt);
    if (active_set().is_held() || (solved && is_within_bounds(stage.knot, k))) return solved;
    return solve_in_box(stage, k, Kt);
  }

 private:
  bool is_within_bounds(int knot, const Eigen::Ref<const Eigen::VectorXd>& k) {
    return (k.array() >= active_set().lower(knot).array()).all() &&
           (k.array() <= active_set().upper(knot).array()).all();
  }

  /// Minimizes the stage between its bounds, starting from the active set of the previous sweep.
  bool solve_in_box(const StageProblem& stage, Eigen::Ref<Eigen::VectorXd> k, const LaneBlock& Kt) {
    const int nu = static_cast<int>(k.size());
    const std::span<BoundState> active = active_set().states(stage.knot);
    std::copy(active.begin(), active.end(), before_.begin());
    if (qp_.solve(stage.Quu, stage.Qu, active_set().lower(stage.knot),
                  active_set().upper(stage.knot), active) == BoxQp::Status::not_positive_definite)
      return false;
    k = qp_.x();
    // Feedback acts only on the free controls: K_f = −Q_ff⁻¹ Q_fx.
    const auto free = qp_.free();
    const int count = static_cast<int>(free.size());
    rhs_.resize(Kt.rows, count);
    for (int j = 0; j < count; ++j) stage.negate(free[j], rhs_.block(), j);
    solve_rows_in_place(qp_.free_factor(), rhs_.block());
    Kt.view().setZero();
    for (int j = 0; j < count; ++j) Kt.view().col(free[j]) = rhs_.view().col(j);
    int changes = 0;
    for (int i = 0; i < nu; ++i) changes += active[i] != before_[i];
    active_set().count_changes(changes);
    if (count < nu) active_set().remember(stage);
    return true;
  }

  /// Puts the held entries (at least one) at their bounds and lists the others.
  void hold_entries(int knot, Eigen::Ref<Eigen::VectorXd> k) {
    const std::span<const BoundState> active = active_set().states(knot);
    free_.clear();
    for (int i = 0; i < k.size(); ++i) {
      if (active[i] == BoundState::free)
        free_.push_back(i);
      else
        k[i] = (active[i] == BoundState::at_lower ? active_set().lower(knot)
                                                  : active_set().upper(knot))[i];
    }
  }

  /// Loads the block of the free entries, and right-hand sides whose gradient includes the held
  /// entries.
  void load_free(const StageProblem& stage, const Eigen::Ref<const Eigen::VectorXd>& k) {
    const int count = static_cast<int>(free_.size());
    auto factor = factor_.view();
    const LaneBlock solution = rhs_.block();
    auto rhs = solution.view();
    const int gradient = solution.rows - 1;
    for (int a = 0; a < count; ++a) {
      for (int b = a; b < count; ++b) factor(b, a) = stage.Quu(free_[b], free_[a]);
      stage.negate(free_[a], solution, a);
      for (int i = 0; i < k.size(); ++i)
        if (active_set().holds(stage.knot, i)) rhs(gradient, a) -= stage.Quu(i, free_[a]) * k[i];
    }
  }

  /// Minimizes the stage with the held entries fixed at their bounds.
  bool solve_held(const StageProblem& stage, Eigen::Ref<Eigen::VectorXd> k, const LaneBlock& Kt) {
    const int rows = Kt.rows - 1;
    hold_entries(stage.knot, k);
    const int count = static_cast<int>(free_.size());
    factor_.resize(count, count);
    // One solve serves both: the gradient is an additional row of right-hand sides.
    rhs_.resize(rows + 1, count);
    const LaneBlock solution = rhs_.block();
    auto rhs = solution.view();
    load_free(stage, k);
    if (!cholesky_in_place(factor_.block())) return false;
    solve_rows_in_place(factor_.block(), solution);
    for (int a = 0; a < count; ++a) k[free_[a]] = rhs(rows, a);
    Kt.view().setZero();
    for (int a = 0; a < count; ++a) Kt.view().col(free_[a]) = rhs.col(a);
    active_set().remember(stage);
    return true;
  }

  BoxQp qp_;
  LaneMatrix factor_, rhs_;
  std::vector<BoundState> before_;
  std::vector<int> free_;
};

}  // namespace

std::unique_ptr<StageSolver> box_stage(const ShootingProblem& problem) {
  return std::make_unique<BoxStage>(problem, largest_nu(problem));
}

}  // namespace conddp
