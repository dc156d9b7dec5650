#pragma once

#include <string>
#include <vector>

#include <Eigen/Core>

namespace conddp {

/// The number of independent rows of a system's contacts in a state, from the eigenvalues of G = J
/// M⁻¹ Jᵀ scaled to a unit diagonal. Rows along which the contact cannot move, such as those out of
/// the plane of a planar robot, do not count.
struct ContactRank {
  int rows = 0;  ///< 0 without contacts
  int rank = 0;
  /// Contacts that can push against each other without moving any joint, so that their forces are
  /// not determined; empty if rank = rows.
  std::vector<std::string> redundant;
  /// A matrix that makes nearly or fully redundant contact forces determined and moderate: added to
  /// G, it raises the eigenvalues to 0.01. Square in all rows, or empty.
  Eigen::MatrixXd softness;
};

}  // namespace conddp
