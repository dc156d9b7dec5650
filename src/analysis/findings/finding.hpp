#pragma once

#include <map>
#include <set>
#include <string>
#include <string_view>
#include <vector>

namespace conddp {

/// Kind of a finding; findings are listed in this order.
enum class FindingKind {
  unstable_steps,      ///< growth per step of a motion that decays or oscillates in time
  position_limit,      ///< joint beyond its limit, rad or m
  velocity_limit,      ///< likewise, rad/s or m/s
  effort_limit,        ///< control at its limit, s; or beyond it, Nm or N
  drift,               ///< motion of a held contact, m
  friction_demand,     ///< friction coefficient that a contact's forces need
  pull,                ///< pulling force of a contact, N (Ns at an impulse)
  redundant_contacts,  ///< dependent contacts: rows beyond the independent ones
  constraint_row,      ///< most violated row of a constraint, in its unit
  between_knots,  ///< violation between knots or at the end, not at knots, in the constraint's unit
  table_range,    ///< table read beyond its points: excess in its argument's unit
  last_knot,      ///< jump of a quantity in the last step, in its unit
  thrusters,      ///< directions about which thrusters cannot turn a body
  coarse_grid,    ///< error of a grid's steps relative to the motion, if not resolved
};

/// Name in outputs: "position_limit", ...
std::string_view to_string(FindingKind kind);

/// A property of a motion that is worth knowing although its problem may not constrain it.
struct Finding {
  FindingKind kind = FindingKind::position_limit;
  std::string subject;  ///< the joint, control, contact, constraint, table or body
  double value = 0;     ///< size, in `unit`
  std::string unit;
  int knot = -1;        ///< worst place; −1: no particular knot
  double time = 0;      ///< time of that knot, s
  std::string message;  ///< one sentence with figures
  std::string remedy;   ///< suggestion; empty if nothing has to change
  bool jumps = false;   ///< between_knots only: the motion passes through an obstacle
};

/// Names and facts that a problem itself does not contain.
struct FindingNames {
  std::map<std::string, double> friction;  ///< friction coefficients of contacts
  /// Keys of contacts that do not stand under `contacts`: "loops.knee" of knee.
  std::map<std::string, std::string> contact_keys = {};
  /// Names for the rows of a constraint with several rows, to follow the words "violated by". The
  /// key is the name of the constraint, with the prefix "terminal/" at the terminal node.
  struct Rows {
    std::vector<std::string> names;
    std::string unit = {};
  };
  std::map<std::string, Rows> rows;
  /// Quantities that the URDF's limits bound throughout: "configuration", "velocity", "control".
  std::set<std::string> bounded;
  std::set<std::string> bounded_to_the_end = {};  ///< those of them with 'nodes: ends'
  /// A cost or constraint on the friction cone of a contact.
  struct Cone {
    std::string name;
    bool constraint = false;
    bool throughout = true;  ///< at all knots
  };
  std::map<std::string, std::vector<Cone>> cones = {};  ///< by contact
};

}  // namespace conddp
