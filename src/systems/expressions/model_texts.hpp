#pragma once

#include <memory>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "systems/expressions/parser.hpp"

namespace conddp {

/// An expression and the name of its result.
struct NamedExpression {
  std::string name;
  std::string text;
};

/// A constant of expressions: a number or a vector.
struct ParameterValue {
  ParameterValue(double number) : numbers{number}, is_vector(false) {}
  ParameterValue(std::vector<double> vector) : numbers(std::move(vector)), is_vector(true) {}
  std::vector<double> numbers;
  bool is_vector;
};

using NamedParameters = std::vector<std::pair<std::string, ParameterValue>>;
using NamedTables = std::vector<std::pair<std::string, std::shared_ptr<const SplineTable>>>;

/// An error or warning about one text of a system or residual.
struct ModelMessage {
  enum class Part {
    kState,
    kVelocity,
    kControl,
    kParameter,
    kTable,
    kDefinition,
    kEquation,  ///< of a system
    kRow,       ///< of a residual
    kOperand,   ///< another residual that a residual refers to
    kWhole
  };
  Part part = Part::kWhole;
  int index = 0;
  /// True if the message is about the text of the expression, at an offset; false if about the
  /// name.
  bool in_text = false;
  ExpressionMessage message;
};

/// Reads the texts of a model into a graph and a scope; errors and warnings go into lists.
class ModelTextReader {
 public:
  using Part = ModelMessage::Part;

  /// `time_is_known`: `t` means the time, even if the scope does not contain it yet.
  ModelTextReader(ExpressionGraph& graph, bool time_is_known, std::vector<ModelMessage>& errors,
                  std::vector<ModelMessage>& warnings)
      : graph_(graph), time_is_known_(time_is_known), errors_(errors), warnings_(warnings) {}

  ExpressionScope& scope() { return scope_; }
  bool good() const { return errors_.empty(); }

  /// Reports an error about a name or about the model as a whole.
  void report(Part part, int index, std::string message, std::string hint = {});
  /// Reports an error about the text of an expression.
  void report_text(Part part, int index, std::string message, std::string hint = {});
  /// Adds a name, or reports why it is invalid.
  void add(Part part, int index, const std::string& name, ExpressionValue value);
  void add_parameters(const NamedParameters& parameters);
  void add_tables(const NamedTables& tables);
  /// Adds the definitions in order and stops at the first error, because later ones may depend on
  /// it.
  void add_definitions(const std::vector<NamedExpression>& definitions);
  /// The value of an expression; nothing if it has an error.
  std::optional<ExpressionValue> parse(Part part, int index, const std::string& text);

 private:
  bool check_name(Part part, int index, const std::string& name);

  ExpressionGraph& graph_;
  const bool time_is_known_;
  std::vector<ModelMessage>& errors_;
  std::vector<ModelMessage>& warnings_;
  ExpressionScope scope_;
};

}  // namespace conddp
