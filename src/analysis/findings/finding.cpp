#include "analysis/findings/finding.hpp"

namespace conddp {

std::string_view to_string(FindingKind kind) {
  constexpr std::string_view kNames[] = {
      "unstable_steps",  "position_limit", "velocity_limit",     "effort_limit",   "drift",
      "friction_demand", "pull",           "redundant_contacts", "constraint_row", "between_knots",
      "table_range",     "last_knot",      "thrusters",          "coarse_grid"};
  return kNames[static_cast<int>(kind)];
}

}  // namespace conddp
