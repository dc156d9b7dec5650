#pragma once

#include <optional>
#include <string>

#include "analysis/certificate/judged_point.hpp"

namespace conddp {

/// A kink or a jump where derivatives hold to one side alone, and the Lagrangian falls to the
/// other.
struct FallingKink {
  int node = -1;
  std::string part;  ///< "cost 'effort'", "constraint 'table'" or "the dynamics"
  double fall = 0;   ///< by moves of one range, summed over all nodes, in the unit of the costs
};

/// Compares the slopes of the Lagrangian with differences to both sides along random directions,
/// within the bounds of the controls. Multipliers and co-states are those of the point. Differences
/// that remain below the slope however short the step is belong to a kink, where the first and
/// second derivatives of one side prove nothing. Kinks to the other side do no harm: the Lagrangian
/// rises along them. Returns nullopt if the falls add up to no more than a negligible share of
/// `cost_size`.
std::optional<FallingKink> find_falling_kink(const JudgedPoint& point, double cost_size);

}  // namespace conddp
