#include "solvers/stages/stage_problem.hpp"

#include <algorithm>

#include "solvers/linalg/cholesky.hpp"
#include "spatial/lane_memory.hpp"

namespace conddp {

int largest_nu(const ShootingProblem& problem) {
  int largest = 0;
  for (int k = 0; k < problem.knots(); ++k) largest = std::max(largest, problem.nu(k));
  return largest;
}

void StageProblem::negate(int i, const LaneBlock& to, int j) const {
  const int rows = static_cast<int>(Qxu.rows());
  const double* from = Qxu.col(i).data();
  double* column = to.data + j * to.stride;
  for (int row = 0; row < rows; row += kLaneWidth)
    store_lane(column + row, -load_some(from + row, rows - row));
  column[rows] = -Qu[i];
}

bool StageProblem::solve_free(LaneMatrix& factor, Eigen::Ref<Eigen::VectorXd> k,
                              const LaneBlock& Kt) const {
  const int nu = Kt.cols;
  factor.resize(nu, nu);
  for (int j = 0; j < nu; ++j)
    for (int row = j / kLaneWidth * kLaneWidth; row < nu; row += kLaneWidth)
      store_lane(factor.col(j) + row, load_some(Quu.col(j).data() + row, nu - row));
  if (!cholesky_in_place(factor.block())) return false;
  // One solve serves both: the gradient is an additional row of right-hand sides.
  for (int j = 0; j < nu; ++j) negate(j, Kt, j);
  solve_rows_in_place(factor.block(), Kt);
  for (int j = 0; j < nu; ++j) k[j] = Kt.data[j * Kt.stride + Kt.rows - 1];
  return true;
}

}  // namespace conddp
