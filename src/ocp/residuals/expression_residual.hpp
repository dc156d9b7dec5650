#pragma once

#include <memory>
#include <string>
#include <vector>

#include "ocp/terms/residual.hpp"
#include "systems/expressions/model_texts.hpp"

namespace conddp {

/// A name in the expressions of a knot: numbers of its state and control in order.
struct KnotName {
  struct Number {
    bool of_control;
    int index;  ///< into the state or the control
  };
  std::string name;
  std::string unit;
  std::vector<Number> numbers;  ///< one: a number; several, or with parts: a vector
  std::vector<ExpressionValue::Part> parts;
};

/// The names of a system's columns. A column whose name is valid in expressions keeps it; columns
/// called group/element form the vector `group` with the parts `element`. Poses also have the parts
/// `position` and `rotation`, twists `linear` and `angular`.
std::vector<KnotName> knot_names(const System& system);

/// Another residual whose rows are available in expressions, as parts of a vector.
struct ExpressionOperand {
  std::string name;
  std::shared_ptr<const Residual> residual;
  std::vector<double> parameters;  ///< used at every knot
  std::vector<std::string> rows;   ///< row names
};

/// A residual in text form: rows minus their references. Expressions may use names of the knot,
/// operands, parameters, definitions in their order, and tables. Unless these define them, they may
/// also use the time `t`, the time since the beginning of the phase, `phase_time`, and the time of
/// the last node, `final_time` (s).
struct ExpressionResidualText {
  std::vector<KnotName> names;
  std::vector<ExpressionOperand> operands;
  NamedParameters parameters;
  NamedTables tables;
  std::vector<NamedExpression> definitions;
  std::vector<std::string> rows;  ///< a vector gives several rows
  bool constants = false;         ///< true if a row may be constant
  /// State indices of the free phase durations, s: times grow with them.
  std::vector<int> durations;
};

/// A residual, or the errors that prevented it.
struct ParsedExpressionResidual {
  std::shared_ptr<const Residual> residual;
  std::vector<int> rows;  ///< number of rows of each text
  bool reads_time = false;
  std::vector<ModelMessage> errors;
  std::vector<ModelMessage> warnings;
};

/// Makes a residual from expressions of a knot whose model has this manifold. Parameters: the
/// reference of each row. If expressions depend on times, these follow: `t`, `phase_time` and
/// `final_time` without the free durations (s), the factor of each free duration in `t`, and its
/// factor in `phase_time`. Its factor in `final_time` is 1. The residual needs a control if
/// expressions or operands depend on it.
ParsedExpressionResidual make_expression_residual(const StateManifold& manifold,
                                                  const ExpressionResidualText& text);

}  // namespace conddp
