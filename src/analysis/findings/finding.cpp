#include "analysis/findings/finding.hpp"

namespace conddp {

std::string_view to_string(FindingKind kind) {
  switch (kind) {
    case FindingKind::unstable_steps:
      return "unstable_steps";
    case FindingKind::coarse_grid:
      return "coarse_grid";
    case FindingKind::position_limit:
      return "position_limit";
    case FindingKind::velocity_limit:
      return "velocity_limit";
    case FindingKind::effort_limit:
      return "effort_limit";
    case FindingKind::drift:
      return "drift";
    case FindingKind::friction_demand:
      return "friction_demand";
    case FindingKind::pull:
      return "pull";
    case FindingKind::redundant_contacts:
      return "redundant_contacts";
    case FindingKind::constraint_row:
      return "constraint_row";
    case FindingKind::between_knots:
      return "between_knots";
    case FindingKind::table_range:
      return "table_range";
    case FindingKind::last_knot:
      return "last_knot";
    case FindingKind::thrusters:
      break;
  }
  return "thrusters";
}

}  // namespace conddp
