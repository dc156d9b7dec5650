#pragma once

#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "systems/expressions/model_texts.hpp"
#include "systems/system.hpp"

namespace conddp {

/// A state of a system of expressions, or a position of a second-order one.
struct ExpressionState {
  enum class Kind {
    kNumber,
    kUnitQuaternion,  ///< x y z w; its rate is the angular velocity in body axes, rad/s
    kPose,            ///< position and unit quaternion; its rate is the twist in body axes
  };
  std::string name;
  std::string unit = "1";
  Kind kind = Kind::kNumber;
  /// True for a state of other phases: expressions cannot refer to it, and without an equation it
  /// is at rest. Not allowed in second-order systems.
  bool hidden = false;
};

/// Times that the equations of a phase may use besides `t`, in s: `phase_time`, which is t minus
/// the beginning of the phase, and `final_time`.
struct SystemTimes {
  double begin = 0, final = 0;  ///< excluding free durations
  /// Names of the free durations of all phases. Each is an additional state in s, at rest. All of
  /// them add to the final time.
  std::vector<std::string> durations;
  std::vector<bool> before;  ///< true if the duration adds to the beginning of the phase
};

/// The text of a system: first order (rates of the states), second order (accelerations; states are
/// positions and velocities) or discrete (next states).
///
/// Names in expressions: states, velocities and controls, parameters, definitions in order, and
/// tables. Unless the system is discrete, also the time `t` and, if these names are free,
/// `phase_time` and `final_time` (s). A unit quaternion is a vector of 4; a pose is a vector of 7
/// with the parts `position` and `rotation`. Their velocities are vectors of 3, and of 6 with the
/// parts `linear` and `angular`.
struct ExpressionSystemText {
  SystemKind kind = SystemKind::first_order;
  std::vector<ExpressionState> states;
  std::vector<Column> velocities;  ///< of a second-order system, one for each position
  std::vector<Column> controls;
  NamedParameters parameters;
  NamedTables tables;
  std::vector<NamedExpression> definitions;
  /// The rate, acceleration or next value of each state, in any order. The name is that of the
  /// state, or of the velocity in a second-order system.
  std::vector<NamedExpression> equations;
  /// True if the state includes the clock even if nothing depends on the time.
  bool clock = false;
  /// Times of a phase. Without them both times are 0 at t = 0, for a system used only for its
  /// columns and messages.
  std::optional<SystemTimes> times;
};

/// A system, or the reasons for its absence.
struct ParsedExpressionSystem {
  std::shared_ptr<const System> system;
  /// A default initial state: all numbers 0, no rotation, the clock at 0 and running.
  std::vector<double> usual_state;
  bool reads_phase_times = false;  ///< true if it depends on `phase_time` or `final_time`
  std::vector<ModelMessage> errors;
  std::vector<ModelMessage> warnings;
};

/// Makes a system of expressions. If they depend on the time or the text requests it, the state
/// includes the clock `t` (s). The clock follows the states; in a second-order system it follows
/// the positions, and its velocity `t_rate` (s/s), initially 1, follows the velocities. The free
/// durations in `times` come next; in a second-order system they have velocities, initially 0.
ParsedExpressionSystem make_expression_system(const ExpressionSystemText& text);

}  // namespace conddp
