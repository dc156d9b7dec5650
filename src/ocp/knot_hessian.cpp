#include "ocp/knot_hessian.hpp"

namespace conddp {

KnotHessian::KnotHessian(int nz, std::span<const std::pair<int, int>> lasting)
    : matrix_(Eigen::MatrixXd::Zero(nz, nz)), fill_(HessianFill::lasting), lasting_lanes_(nz, 0) {
  for (const auto& [row, column] : lasting)
    lasting_lanes_[column] |= std::uint64_t{1} << lane_bit(row);
}

}  // namespace conddp
