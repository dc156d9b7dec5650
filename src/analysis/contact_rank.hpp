#pragma once

#include <string>
#include <vector>

#include "systems/system.hpp"

namespace conddp {

/// How many of the rows of a system's contacts are independent in a state, by the eigenvalues of
/// G = J M⁻¹ Jᵀ against the compliance that ContactSet gives a singular one. Rows along which the
/// contact cannot move at all, as out of the plane of a planar robot, do not count.
struct ContactRank {
  int rows = 0;  ///< 0: no contact is held
  int rank = 0;
  /// Contacts that can push against each other without moving any joint, so that nothing determines
  /// how much; none where rank = rows.
  std::vector<std::string> redundant;
};

/// `x`: a state of nx numbers; where G is not finite there, all rows count as independent.
ContactRank contact_rank(const System& system, const double* x);

}  // namespace conddp
