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
  /// No expression knows its name, and without an equation it rests: a state of other phases. Not
  /// of second-order systems.
  bool hidden = false;
};

/// What equations of a phase name of the time besides `t`, s: `phase_time`, which is t minus the
/// beginning of the phase, and `final_time`.
struct SystemTimes {
  double begin = 0, final = 0;  ///< without what free durations add
  /// The free durations of all phases, each a further state, s, which rests: its column. All count
  /// in the final time.
  std::vector<std::string> durations;
  std::vector<bool> before;  ///< whether each counts in the beginning of the phase
};

/// A system in words: first order (rates of the states), second order (accelerations, states are
/// positions and velocities) or discrete (next states).
///
/// Names in expressions: states, velocities and controls, parameters, definitions in their order,
/// tables, and unless the system is discrete the time `t` and, where nothing else has these names,
/// `phase_time` and `final_time` (s). A unit quaternion is a vector of 4;
/// a pose is a vector of 7 with the parts `position` and `rotation`; velocities of these are
/// vectors of 3, and of 6 with the parts `linear` and `angular`.
struct ExpressionSystemText {
  SystemKind kind = SystemKind::first_order;
  std::vector<ExpressionState> states;
  std::vector<Column> velocities;  ///< of a second-order system, one for each position
  std::vector<Column> controls;
  NamedParameters parameters;
  NamedTables tables;
  std::vector<NamedExpression> definitions;
  /// The rate, acceleration or next value of each state, by its name (of a second-order system by
  /// that of the velocity), in any order.
  std::vector<NamedExpression> equations;
  /// Whether the state has the clock although nothing depends on the time.
  bool clock = false;
  /// Of a phase. Without it both times are 0 at t = 0, for a system whose columns and messages
  /// count alone.
  std::optional<SystemTimes> times;
};

/// A system, or why there is none.
struct ParsedExpressionSystem {
  std::shared_ptr<const System> system;
  /// A state to begin from: all numbers 0, no rotation, the clock at 0 and going.
  std::vector<double> usual_state;
  bool reads_phase_times = false;  ///< whether it depends on `phase_time` or `final_time`
  std::vector<ModelMessage> errors;
  std::vector<ModelMessage> warnings;
};

/// Makes a system of expressions. Where these depend on the time or the text asks for it, the state
/// gets the clock `t` (s):
/// behind the states, of a second-order system behind the positions, with the velocity `t_rate`
/// (s/s) behind the velocities, which has to be 1 at the beginning. Behind it stand free durations,
/// where `times` have some, of a second-order system with velocities that have to be 0.
ParsedExpressionSystem make_expression_system(const ExpressionSystemText& text);

}  // namespace conddp
