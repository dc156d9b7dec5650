#pragma once

#include <string>
#include <vector>

#include <Eigen/Core>

namespace conddp {

/// How many of the rows of a system's contacts are independent in a state, by the eigenvalues of
/// G = J M⁻¹ Jᵀ with its rows and columns scaled to a diagonal of ones. Rows along which the
/// contact cannot move at all, as out of the plane of a planar robot, do not count.
struct ContactRank {
  int rows = 0;  ///< 0: no contact is held
  int rank = 0;
  /// Contacts that can push against each other without moving any joint, so that nothing determines
  /// how much; none where rank = rows.
  std::vector<std::string> redundant;
  /// What makes forces of such contacts, and of those that hardly move anything, determined and
  /// moderate: added to G, it raises the eigenvalues to 0.01. All rows square, or empty.
  Eigen::MatrixXd softness;
};

}  // namespace conddp
