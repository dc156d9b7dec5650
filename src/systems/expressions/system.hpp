#pragma once

#include <memory>
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

/// A system in words: first order (rates of the states), second order (accelerations, states are
/// positions and velocities) or discrete (next states).
///
/// Names in expressions: states, velocities and controls, parameters, definitions in their order,
/// tables, and the time `t` (s) unless the system is discrete. A unit quaternion is a vector of 4;
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
};

/// A system, or why there is none.
struct ParsedExpressionSystem {
  std::shared_ptr<const System> system;
  /// A state to begin from: all numbers 0, no rotation, the clock at 0 and going.
  std::vector<double> usual_state;
  std::vector<ModelMessage> errors;
  std::vector<ModelMessage> warnings;
};

/// Makes a system of expressions. Where these depend on the time or the text asks for it, the state
/// gets the clock `t` (s):
/// behind the states, of a second-order system behind the positions, with the velocity `t_rate`
/// (s/s) behind the velocities, which has to be 1 at the beginning.
ParsedExpressionSystem make_expression_system(const ExpressionSystemText& text);

}  // namespace conddp
