#include <algorithm>
#include <vector>

#include "solvers/linalg/cholesky.hpp"
#include "solvers/riccati/box_qp.hpp"
#include "solvers/riccati/stage_policy.hpp"
#include "solvers/riccati/stage_sweep.hpp"

namespace conddp {
namespace {

class BoxStage : public StagePolicy {
 public:
  BoxStage(const ShootingProblem& problem, int max_nu, const SolverOptions::BoxQp& options,
           int segments) {
    const int rows = segments > 1 ? parametric_rows(problem) : problem.ndx();
    scratch_.reserve(segments);
    for (int segment = 0; segment < segments; ++segment)
      scratch_.emplace_back(rows, max_nu, options);
    for (int k = 0; k < problem.knots(); ++k) {
      const int nu = problem.nu(k);
      active_.emplace_back(nu);
      kept_.push_back({Eigen::MatrixXd(problem.ndx(), nu), Eigen::MatrixXd(nu, nu),
                       Eigen::VectorXd(nu), Eigen::VectorXd(nu), Eigen::VectorXd(nu)});
    }
  }

  void begin_sweep(bool hold) override {
    changes_ = 0;
    hold_ = hold;
  }

  bool solve(const StageProblem& stage, Eigen::Ref<Eigen::VectorXd> k, LaneBlock Kt) override {
    Scratch& scratch = scratch_[stage.segment];
    const std::vector<BoundState>& active = active_[stage.knot];
    Kept& kept = kept_[stage.knot];
    kept.lower = stage.lower - stage.u;
    kept.upper = stage.upper - stage.u;
    const bool unbound =
        std::all_of(active.begin(), active.end(), [](auto a) { return a == BoundState::free; });
    if (hold_ && !unbound) {
      if (!solve_held(stage, active, kept, scratch, k, Kt)) return false;
      keep(stage, kept);
      return true;
    }
    if (!unbound) return solve_in_box(stage, k, Kt);
    // Most knots are far from every bound: there the free minimum is that of the QP.
    const bool solved = stage.solve_free(scratch.factor, k, Kt);
    if (hold_) return solved;
    if (solved && (k.array() >= kept.lower.array()).all() &&
        (k.array() <= kept.upper.array()).all())
      return true;
    return solve_in_box(stage, k, Kt);
  }

  int revise(int knot, const Eigen::Ref<const Eigen::VectorXd>& dx,
             const Eigen::Ref<const Eigen::VectorXd>& du) override {
    const Kept& kept = kept_[knot];
    std::vector<BoundState>& active = active_[knot];
    int changes = 0;
    for (int i = 0; i < du.size(); ++i) {
      const BoundState state = active[i] == BoundState::free
                                   ? kept.state_beyond(i, du[i])
                                   : kept.state_by_multiplier(i, active[i], dx, du);
      changes += state != active[i];
      active[i] = state;
    }
    changes_ += changes;
    return changes;
  }

  void change_gradient(int knot, const Eigen::Ref<const Eigen::VectorXd>& change) override {
    kept_[knot].Qu += change;
  }

  void assume_sides(int knot, const Eigen::Ref<const Eigen::VectorXd>& side) override {
    for (int i = 0; i < side.size(); ++i) {
      BoundState& state = active_[knot][i];
      const BoundState now = side[i] < 0   ? BoundState::at_lower
                             : side[i] > 0 ? BoundState::at_upper
                                           : BoundState::free;
      changes_ += state != now;
      state = now;
    }
  }

  void release() override {
    for (auto& knot : active_) std::fill(knot.begin(), knot.end(), BoundState::free);
  }

  bool holds(int knot, int i) const override { return active_[knot][i] != BoundState::free; }

  int clamped_controls() const override {
    int count = 0;
    for (const auto& knot : active_)
      count +=
          static_cast<int>(knot.size() - std::count(knot.begin(), knot.end(), BoundState::free));
    return count;
  }
  int active_set_changes() const override { return changes_; }

 private:
  /// What the last sweep saw at a knot; bounds are those of δu.
  struct Kept {
    Eigen::MatrixXd Qxu, Quu;
    Eigen::VectorXd Qu, lower, upper;

    /// Of a free entry of δu.
    BoundState state_beyond(int i, double du) const {
      if (du > upper[i]) return BoundState::at_upper;
      return du < lower[i] ? BoundState::at_lower : BoundState::free;
    }
    /// Of a held one: free where its multiplier has the wrong sign.
    BoundState state_by_multiplier(int i, BoundState state,
                                   const Eigen::Ref<const Eigen::VectorXd>& dx,
                                   const Eigen::Ref<const Eigen::VectorXd>& du) const {
      if (!(lower[i] < upper[i])) return state;
      const double gradient = Qu[i] + Quu.col(i).dot(du) + Qxu.col(i).dot(dx);
      return (state == BoundState::at_lower) == (gradient < 0) ? BoundState::free : state;
    }
  };

  /// Memory of one stage.
  struct Scratch {
    Scratch(int rows, int max_nu, const SolverOptions::BoxQp& options)
        : qp(max_nu, options.max_iterations, options.armijo),
          factor(max_nu, max_nu),
          rhs(rows + 1, max_nu),
          before(max_nu) {
      free.reserve(max_nu);
    }
    BoxQp qp;
    LaneMatrix factor, rhs;
    std::vector<BoundState> before;
    std::vector<int> free;
  };

  /// The stage's minimum between its bounds, from the active set of the sweep before.
  bool solve_in_box(const StageProblem& stage, Eigen::Ref<Eigen::VectorXd> k, LaneBlock Kt) {
    const int nu = static_cast<int>(k.size());
    Scratch& scratch = scratch_[stage.segment];
    std::vector<BoundState>& active = active_[stage.knot];
    Kept& kept = kept_[stage.knot];
    std::copy(active.begin(), active.end(), scratch.before.begin());
    if (scratch.qp.solve(stage.Quu, stage.Qu, kept.lower, kept.upper, active) ==
        BoxQp::Status::not_positive_definite)
      return false;
    k = scratch.qp.x();
    // Feedback acts on the free controls alone: K_f = −Q_ff⁻¹ Q_fx.
    const auto free = scratch.qp.free();
    const int count = static_cast<int>(free.size());
    scratch.rhs.resize(Kt.rows, count);
    for (int j = 0; j < count; ++j) stage.negate(free[j], scratch.rhs.block(), j);
    solve_rows_in_place(scratch.qp.free_factor(), scratch.rhs.block());
    Kt.view().setZero();
    for (int j = 0; j < count; ++j) Kt.view().col(free[j]) = scratch.rhs.view().col(j);
    for (int i = 0; i < nu; ++i) changes_ += active[i] != scratch.before[i];
    if (count < nu) keep(stage, kept);
    return true;
  }

  /// Keeps what `revise` needs of a stage where something is held.
  static void keep(const StageProblem& stage, Kept& kept) {
    kept.Qxu = stage.Qxu.topRows(kept.Qxu.rows());
    kept.Quu = stage.Quu;
    kept.Qu = stage.Qu;
  }

  /// The stage's minimum with the entries that `active` holds, one at least, put at their bounds.
  static bool solve_held(const StageProblem& stage, const std::vector<BoundState>& active,
                         const Kept& kept, Scratch& scratch, Eigen::Ref<Eigen::VectorXd> k,
                         LaneBlock Kt) {
    const int nu = Kt.cols, rows = Kt.rows - 1;
    std::vector<int>& free = scratch.free;
    free.clear();
    for (int i = 0; i < nu; ++i) {
      if (active[i] == BoundState::free)
        free.push_back(i);
      else
        k[i] = active[i] == BoundState::at_lower ? kept.lower[i] : kept.upper[i];
    }
    const int count = static_cast<int>(free.size());
    scratch.factor.resize(count, count);
    auto factor = scratch.factor.view();
    // One solve for both: the gradient is one more row of right-hand sides.
    scratch.rhs.resize(rows + 1, count);
    const LaneBlock solution = scratch.rhs.block();
    auto rhs = solution.view();
    for (int a = 0; a < count; ++a) {
      for (int b = a; b < count; ++b) factor(b, a) = stage.Quu(free[b], free[a]);
      stage.negate(free[a], solution, a);
      for (int i = 0; i < nu; ++i)
        if (active[i] != BoundState::free) rhs(rows, a) -= stage.Quu(i, free[a]) * k[i];
    }
    if (!cholesky_in_place(scratch.factor.block())) return false;
    solve_rows_in_place(scratch.factor.block(), solution);
    for (int a = 0; a < count; ++a) k[free[a]] = rhs(rows, a);
    Kt.view().setZero();
    for (int a = 0; a < count; ++a) Kt.view().col(free[a]) = rhs.col(a);
    return true;
  }

  std::vector<Kept> kept_;
  std::vector<Scratch> scratch_;  ///< of stages that are solved at once
  bool hold_ = false;
  std::vector<std::vector<BoundState>> active_;  ///< of all knots, kept from sweep to sweep
  int changes_ = 0;
};

}  // namespace

std::unique_ptr<StagePolicy> box_stage(const ShootingProblem& problem,
                                       const SolverOptions::BoxQp& options, int segments) {
  return std::make_unique<BoxStage>(problem, largest_nu(problem), options, segments);
}

}  // namespace conddp
