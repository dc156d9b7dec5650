#pragma once

#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "systems/expressions/value.hpp"

namespace conddp {

/// What names mean in an expression. The constants and functions of the language are known without
/// being in a scope.
class ExpressionScope {
 public:
  /// Why a name cannot be added, as a sentence: it is none, taken by the language, or in the scope
  /// already; empty where it can.
  std::string defect_of(std::string_view name) const;
  /// The name must have no defect.
  void add(std::string name, ExpressionValue value);
  /// A table of the graph, called like a function.
  void add_table(std::string name, int table, int arguments);
  /// Says why a name cannot be used, for the hint where an expression has it all the same; it may
  /// be added later.
  void explain(std::string name, std::string why);

  struct Table {
    int index;
    int arguments;
  };
  /// Null where the name is not known.
  const ExpressionValue* find(std::string_view name) const;
  const Table* find_table(std::string_view name) const;
  /// Of values and constants; of functions and tables: for suggestions.
  std::vector<std::string> value_names() const;
  /// Of vectors that have a part of this name.
  std::vector<std::string> names_with_part(std::string_view part) const;
  /// The longest part of a vector that a text begins with; empty if it begins with none.
  std::string_view part_at(std::string_view text) const;
  /// What explain() said of a name; empty if nothing.
  std::string explanation_of(std::string_view name) const;
  std::vector<std::string> function_names() const;

 private:
  std::vector<std::pair<std::string, ExpressionValue>> values_;
  std::vector<std::pair<std::string, Table>> tables_;
  std::vector<std::pair<std::string, std::string>> explanations_;
};

/// Whether a text can be a name in expressions: letters, digits and '_', no digit at first.
bool is_expression_name(std::string_view text);

}  // namespace conddp
