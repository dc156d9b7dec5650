#include "ocp/knot/knot_hessian.hpp"

#include "spatial/lane.hpp"

namespace conddp {

KnotHessian::KnotHessian(int nz, std::span<const std::pair<int, int>> lasting)
    : matrix_(Eigen::MatrixXd::Zero(nz, nz)), fill_(HessianFill::lasting) {
  const int blocks = (nz + kLaneWidth - 1) / kLaneWidth;  // per column
  std::vector<bool> filled(static_cast<std::size_t>(nz) * blocks);
  for (const auto& [row, column] : lasting) filled[column * blocks + row / kLaneWidth] = true;
  for (int column = 0; column < nz; ++column)
    for (int block = 0; block < blocks; ++block)
      if (filled[column * blocks + block]) lasting_lanes_.push_back({block * kLaneWidth, column});
}

}  // namespace conddp
