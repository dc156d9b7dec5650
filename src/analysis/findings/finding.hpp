#pragma once

#include <map>
#include <set>
#include <string>
#include <string_view>
#include <vector>

namespace conddp {

/// What a finding is about, in the order in which findings stand.
enum class FindingKind {
  unstable_steps,      ///< steps let grow what decays or oscillates: by how much in a step
  position_limit,      ///< a joint is beyond its limit, rad or m
  velocity_limit,      ///< likewise, rad/s or m/s
  effort_limit,        ///< a control is at its limit or beyond; s at it, or Nm and N beyond
  drift,               ///< a held contact moves, m
  friction_demand,     ///< coefficient of friction that a contact's forces need
  pull,                ///< a contact pulls, N (Ns at an impulse)
  redundant_contacts,  ///< contacts depend on each other: rows beyond the independent ones
  constraint_row,      ///< the row of a constraint that is violated most, in its unit
  between_knots,  ///< a constraint holds at knots, but not between them or at the end, in its unit
  table_range,    ///< a table is read beyond its points, by how much in its argument's unit
  last_knot,      ///< a quantity jumps in the last step, in its unit
  thrusters,      ///< directions about which thrusters cannot turn a body
  coarse_grid,    ///< the grid does not resolve the motion: error of its steps by the motion
};

/// The word in outputs: "position_limit", ...
std::string_view to_string(FindingKind kind);

/// What is worth knowing about a motion although its problem may not ask for it.
struct Finding {
  FindingKind kind = FindingKind::position_limit;
  std::string subject;  ///< the joint, control, contact, constraint, table or body
  double value = 0;     ///< how much, in `unit`
  std::string unit;
  int knot = -1;        ///< where it is worst, −1: nowhere in particular
  double time = 0;      ///< s, of that knot
  std::string message;  ///< one sentence with figures
  std::string remedy;   ///< what changes it, empty where nothing has to
  bool jumps = false;   ///< of between_knots: the motion leads through what it should go around
};

/// What a problem alone does not know of itself.
struct FindingNames {
  std::map<std::string, double> friction;  ///< coefficients of contacts
  /// What the rows of a constraint of several rows are, by its name, with the prefix "terminal/" at
  /// the terminal node, after the words "violated by".
  struct Rows {
    std::vector<std::string> names;
    std::string unit = {};
  };
  std::map<std::string, Rows> rows;
  /// Quantities that the URDF's limits bound throughout: "configuration", "velocity", "control".
  std::set<std::string> bounded;
  /// A cost or constraint on the friction cone of a contact.
  struct Cone {
    std::string name;
    bool constraint = false;
    bool throughout = true;  ///< at all knots
  };
  std::map<std::string, std::vector<Cone>> cones = {};  ///< by contact
};

}  // namespace conddp
