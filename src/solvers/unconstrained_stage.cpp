#include <algorithm>

#include "solvers/cholesky.hpp"
#include "solvers/stage_policy.hpp"
#include "spatial/lane_part.hpp"

namespace conddp {
namespace {

class UnconstrainedStage : public StagePolicy {
 public:
  explicit UnconstrainedStage(int max_nu) : factor_(max_nu, max_nu) {}

  bool solve(const StageProblem& stage, Eigen::Ref<Eigen::VectorXd> k, LaneBlock Kt) override {
    const int nu = Kt.cols;
    factor_.resize(nu, nu);
    factor_.view() = stage.Quu;
    if (!cholesky_in_place(factor_.block())) return false;
    // One solve for both: the gradient is one more row of right-hand sides.
    for (int j = 0; j < nu; ++j) stage.negate(j, Kt, j);
    solve_rows_in_place(factor_.block(), Kt);
    k = Kt.view().row(Kt.rows - 1).transpose();
    return true;
  }

 private:
  LaneMatrix factor_;
};

}  // namespace

void StageProblem::negate(int i, LaneBlock to, int j) const {
  const int rows = static_cast<int>(Qxu.rows());
  const double* from = Qxu.col(i).data();
  double* column = to.data + j * to.stride;
  for (int row = 0; row < rows; row += kLaneWidth)
    store_lane(column + row, -load_some(from + row, rows - row));
  column[rows] = -Qu[i];
}

std::unique_ptr<StagePolicy> unconstrained_stage(const ShootingProblem& problem) {
  int max_nu = 0;
  for (int k = 0; k < problem.knots(); ++k) max_nu = std::max(max_nu, problem.nu(k));
  return std::make_unique<UnconstrainedStage>(max_nu);
}

}  // namespace conddp
