#pragma once

#include <memory>
#include <string>
#include <vector>

#include "ocp/terms/residual.hpp"
#include "systems/expressions/model_texts.hpp"

namespace conddp {

/// A name of a knot in expressions: numbers of its state and control in order.
struct KnotName {
  struct Number {
    bool of_control;
    int index;  ///< into the state or the control
  };
  std::string name;
  std::string unit;
  std::vector<Number> numbers;  ///< one: a number; more, or with parts: a vector
  std::vector<ExpressionValue::Part> parts;
};

/// The names of a system's columns: each that is a name of expressions, and for columns called
/// group/element the vector `group` with the parts `element`. Poses also have the parts `position`
/// and `rotation`, twists `linear` and `angular`.
std::vector<KnotName> knot_names(const System& system);

/// Another residual whose rows expressions name, as parts of a vector.
struct ExpressionOperand {
  std::string name;
  std::shared_ptr<const Residual> residual;
  std::vector<double> parameters;  ///< of it, at every knot
  std::vector<std::string> rows;   ///< their names
};

/// A residual in words: rows minus their references. Names in expressions: those of the knot,
/// operands, parameters, definitions in their order, tables, and where these have no such names the
/// time `t`, that since the beginning of the phase, `phase_time`, and that of the last node,
/// `final_time` (s).
struct ExpressionResidualText {
  std::vector<KnotName> names;
  std::vector<ExpressionOperand> operands;
  NamedParameters parameters;
  NamedTables tables;
  std::vector<NamedExpression> definitions;
  std::vector<std::string> rows;  ///< a vector gives several
  bool constants = false;         ///< whether a row may depend on nothing that moves
  /// Where states hold the durations of phases that are free, s: times grow with them.
  std::vector<int> durations;
};

/// A residual, or why there is none.
struct ParsedExpressionResidual {
  std::shared_ptr<const Residual> residual;
  std::vector<int> rows;  ///< how many each text gives
  bool reads_time = false;
  std::vector<ModelMessage> errors;
  std::vector<ModelMessage> warnings;
};

/// Makes a residual of expressions of a knot whose model has this manifold. Parameters: the
/// reference of each row and, where expressions depend on times, what `t`, `phase_time` and
/// `final_time` are without the free durations (s), how often each of these counts in `t`, and how
/// often in `phase_time`; in `final_time` each counts once. It needs a control where expressions or
/// operands depend on one.
ParsedExpressionResidual make_expression_residual(const StateManifold& manifold,
                                                  const ExpressionResidualText& text);

}  // namespace conddp
