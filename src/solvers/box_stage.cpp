#include <algorithm>
#include <vector>

#include "solvers/box_qp.hpp"
#include "solvers/cholesky.hpp"
#include "solvers/stage_policy.hpp"

namespace conddp {
namespace {

class BoxStage : public StagePolicy {
 public:
  BoxStage(const ShootingProblem& problem, int max_nu, const SolverOptions::BoxQp& options)
      : qp_(max_nu, options.max_iterations, options.armijo),
        lower_(max_nu),
        upper_(max_nu),
        factor_(max_nu, max_nu),
        rhs_(problem.ndx() + 1, max_nu),
        before_(max_nu) {
    free_.reserve(max_nu);
    for (int k = 0; k < problem.knots(); ++k) {
      const int nu = problem.nu(k);
      standing_.active.emplace_back(nu);
      kept_.push_back({Eigen::MatrixXd(problem.ndx(), nu), Eigen::MatrixXd(nu, nu),
                       Eigen::VectorXd(nu), Eigen::VectorXd(nu), Eigen::VectorXd(nu)});
    }
    remembered_ = standing_;
  }

  void begin_sweep(bool hold) override {
    standing_.changes = 0;
    hold_ = hold;
  }

  bool solve(const StageProblem& stage, Eigen::Ref<Eigen::VectorXd> k, LaneBlock Kt) override {
    const int nu = static_cast<int>(k.size());
    std::vector<BoundState>& active = standing_.active[stage.knot];
    std::copy(active.begin(), active.end(), before_.begin());
    auto lower = lower_.head(nu);
    auto upper = upper_.head(nu);
    lower = stage.lower - stage.u;
    upper = stage.upper - stage.u;
    const bool unbound =
        std::all_of(active.begin(), active.end(), [](auto a) { return a == BoundState::free; });
    // Most knots are far from every bound: there the free minimum is that of the QP.
    if (hold_ || unbound) {
      const bool solved = solve_held(stage, active, k, Kt);
      if (hold_ && !solved) return false;
      if (hold_ ||
          (solved && (k.array() >= lower.array()).all() && (k.array() <= upper.array()).all())) {
        keep(stage, active);
        return true;
      }
    }
    if (qp_.solve(stage.Quu, stage.Qu, lower, upper, active) ==
        BoxQp::Status::not_positive_definite) {
      return false;
    }
    k = qp_.x();
    // Feedback acts on the free controls alone: K_f = −Q_ff⁻¹ Q_fx.
    const auto free = qp_.free();
    const int count = static_cast<int>(free.size());
    rhs_.resize(Kt.rows, count);
    for (int j = 0; j < count; ++j) stage.negate(free[j], rhs_.block(), j);
    solve_rows_in_place(qp_.free_factor(), rhs_.block());
    Kt.view().setZero();
    for (int j = 0; j < count; ++j) Kt.view().col(free[j]) = rhs_.view().col(j);
    for (int i = 0; i < nu; ++i) standing_.changes += active[i] != before_[i];
    keep(stage, active);
    return true;
  }

  int revise(int knot, const Eigen::Ref<const Eigen::VectorXd>& dx,
             const Eigen::Ref<const Eigen::VectorXd>& du, bool release) override {
    const Kept& kept = kept_[knot];
    std::vector<BoundState>& active = standing_.active[knot];
    int changes = 0;
    for (int i = 0; i < du.size(); ++i) {
      BoundState state = active[i];
      if (state == BoundState::free) {
        if (du[i] < kept.lower[i]) state = BoundState::at_lower;
        if (du[i] > kept.upper[i]) state = BoundState::at_upper;
      } else if (release && kept.lower[i] < kept.upper[i]) {
        const double gradient = kept.Qu[i] + kept.Quu.col(i).dot(du) + kept.Qxu.col(i).dot(dx);
        if ((state == BoundState::at_lower) == (gradient < 0)) state = BoundState::free;
      }
      changes += state != active[i];
      active[i] = state;
    }
    standing_.changes += changes;
    return changes;
  }

  void assume(int knot, const Eigen::Ref<const Eigen::VectorXd>& gradient) override {
    const Kept& kept = kept_[knot];
    for (int i = 0; i < gradient.size(); ++i) {
      standing_.active[knot][i] = kept.lower[i] >= 0 && gradient[i] > 0   ? BoundState::at_lower
                                  : kept.upper[i] <= 0 && gradient[i] < 0 ? BoundState::at_upper
                                                                          : BoundState::free;
    }
  }

  void assume_sides(int knot, const Eigen::Ref<const Eigen::VectorXd>& side) override {
    for (int i = 0; i < side.size(); ++i) {
      BoundState& state = standing_.active[knot][i];
      const BoundState now = side[i] < 0   ? BoundState::at_lower
                             : side[i] > 0 ? BoundState::at_upper
                                           : BoundState::free;
      standing_.changes += state != now;
      state = now;
    }
  }

  void release() override {
    for (auto& knot : standing_.active) std::fill(knot.begin(), knot.end(), BoundState::free);
  }

  bool holds(int knot, int i) const override {
    return standing_.active[knot][i] != BoundState::free;
  }

  void remember() override { remembered_ = standing_; }
  void recall() override { standing_ = remembered_; }

  int clamped_controls() const override {
    int count = 0;
    for (const auto& knot : standing_.active)
      count +=
          static_cast<int>(knot.size() - std::count(knot.begin(), knot.end(), BoundState::free));
    return count;
  }
  int active_set_changes() const override { return standing_.changes; }

 private:
  /// What the last sweep saw at a knot; bounds are those of δu.
  struct Kept {
    Eigen::MatrixXd Qxu, Quu;
    Eigen::VectorXd Qu, lower, upper;
  };

  /// Where the controls of all knots stand, kept from sweep to sweep, and what is said of that.
  struct Standing {
    std::vector<std::vector<BoundState>> active;
    int changes = 0;
  };

  /// Keeps what `revise` needs of a stage.
  void keep(const StageProblem& stage, const std::vector<BoundState>& active) {
    const int nu = static_cast<int>(active.size());
    Kept& kept = kept_[stage.knot];
    kept.lower = lower_.head(nu);
    kept.upper = upper_.head(nu);
    const auto free = std::count(active.begin(), active.end(), BoundState::free);
    if (free == nu) return;
    kept.Qxu = stage.Qxu;
    kept.Quu = stage.Quu;
    kept.Qu = stage.Qu;
  }

  /// The stage's minimum with the entries that `active` holds put at their bounds.
  bool solve_held(const StageProblem& stage, const std::vector<BoundState>& active,
                  Eigen::Ref<Eigen::VectorXd> k, LaneBlock Kt) {
    const int nu = Kt.cols, ndx = Kt.rows - 1;
    free_.clear();
    for (int i = 0; i < nu; ++i) {
      if (active[i] == BoundState::free)
        free_.push_back(i);
      else
        k[i] = active[i] == BoundState::at_lower ? lower_[i] : upper_[i];
    }
    const int count = static_cast<int>(free_.size());
    factor_.resize(count, count);
    auto factor = factor_.view();
    // One solve for both: the gradient is one more row of right-hand sides.
    rhs_.resize(ndx + 1, count);
    const LaneBlock solution = count == nu ? Kt : rhs_.block();
    auto rhs = solution.view();
    for (int a = 0; a < count; ++a) {
      for (int b = a; b < count; ++b) factor(b, a) = stage.Quu(free_[b], free_[a]);
      stage.negate(free_[a], solution, a);
      if (count == nu) continue;
      for (int i = 0; i < nu; ++i)
        if (active[i] != BoundState::free) rhs(ndx, a) -= stage.Quu(i, free_[a]) * k[i];
    }
    if (!cholesky_in_place(factor_.block())) return false;
    solve_rows_in_place(factor_.block(), solution);
    for (int a = 0; a < count; ++a) k[free_[a]] = rhs(ndx, a);
    if (count == nu) return true;
    Kt.view().setZero();
    for (int a = 0; a < count; ++a) Kt.view().col(free_[a]) = rhs.col(a);
    return true;
  }

  BoxQp qp_;
  bool hold_ = false;
  std::vector<Kept> kept_;
  std::vector<int> free_;
  Eigen::VectorXd lower_, upper_;
  LaneMatrix factor_, rhs_;
  Standing standing_;
  Standing remembered_;
  std::vector<BoundState> before_;
};

}  // namespace

std::unique_ptr<StagePolicy> box_stage(const ShootingProblem& problem,
                                       const SolverOptions::BoxQp& options) {
  int max_nu = 0;
  for (int k = 0; k < problem.knots(); ++k) max_nu = std::max(max_nu, problem.nu(k));
  return std::make_unique<BoxStage>(problem, max_nu, options);
}

}  // namespace conddp
