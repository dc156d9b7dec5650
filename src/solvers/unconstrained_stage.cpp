#include <algorithm>

#include "solvers/cholesky.hpp"
#include "solvers/stage_policy.hpp"

namespace conddp {
namespace {

class UnconstrainedStage : public StagePolicy {
 public:
  UnconstrainedStage(int ndx, int max_nu) : factor_(max_nu, max_nu), rhs_(ndx + 1, max_nu) {}

  bool solve(const StageProblem& stage, Eigen::Ref<Eigen::VectorXd> k,
             Eigen::Ref<Eigen::MatrixXd> Kt) override {
    const int nu = static_cast<int>(k.size());
    const int ndx = static_cast<int>(Kt.rows());
    auto L = factor_.topLeftCorner(nu, nu);
    L = stage.Quu;
    if (!cholesky_in_place(L)) return false;
    // One solve for both: the gradient is one more row of right-hand sides.
    rhs_.resize(ndx + 1, nu);
    auto rhs = rhs_.view();
    rhs.topRows(ndx) = -stage.Qxu;
    rhs.row(ndx) = -stage.Qu.transpose();
    solve_rows_in_place(L, rhs_.block());
    Kt = rhs.topRows(ndx);
    k = rhs.row(ndx).transpose();
    return true;
  }

 private:
  Eigen::MatrixXd factor_;
  LaneMatrix rhs_;
};

}  // namespace

std::unique_ptr<StagePolicy> unconstrained_stage(const ShootingProblem& problem) {
  int max_nu = 0;
  for (int k = 0; k < problem.knots(); ++k) max_nu = std::max(max_nu, problem.nu(k));
  return std::make_unique<UnconstrainedStage>(problem.ndx(), max_nu);
}

}  // namespace conddp
