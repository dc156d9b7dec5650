#include "ocp/knot/knot_hessian.hpp"

#include <set>

#include "spatial/lane.hpp"

namespace conddp {

KnotHessian::KnotHessian(int nz, std::span<const std::pair<int, int>> lasting)
    : matrix_(Eigen::MatrixXd::Zero(nz, nz)), fill_(HessianFill::lasting) {
  std::set<std::pair<int, int>> places;
  for (const auto& [row, column] : lasting) places.emplace(column, row / kLaneWidth * kLaneWidth);
  for (const auto& [column, row] : places) lasting_lanes_.push_back({row, column});
}

}  // namespace conddp
