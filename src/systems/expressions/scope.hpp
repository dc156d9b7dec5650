#pragma once

#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "systems/expressions/functions.hpp"

namespace conddp {

/// The meaning of names in an expression. The constants and functions of the language are always
/// known and not part of the scope.
class ExpressionScope {
 public:
  /// Why a name cannot be added, as a sentence: invalid, reserved by the language, or already in
  /// the scope. Empty if it can be added.
  std::string defect_of(std::string_view name) const;
  /// The name must be valid: defect_of() returns an empty string.
  void add(std::string name, ExpressionValue value);
  /// A table of the graph, called like a function.
  void add_table(std::string name, int table, int arguments);
  /// Explains why a name is unavailable; the text is a hint if an expression uses the name. The
  /// name may still be added later.
  void explain(std::string name, std::string why);

  struct Table {
    int index;
    int arguments;
  };
  /// Null if the name is unknown.
  const ExpressionValue* find(std::string_view name) const;
  const Table* find_table(std::string_view name) const;
  /// Names of values and constants, for suggestions. function_names() lists functions and tables.
  std::vector<std::string> value_names() const;
  /// Names of vectors that have a part of this name.
  std::vector<std::string> names_with_part(std::string_view part) const;
  /// The longest vector part that is a prefix of a text; empty if no part is.
  std::string_view part_at(std::string_view text) const;
  /// The text passed to explain() for a name; empty without one.
  std::string explanation_of(std::string_view name) const;
  std::vector<std::string> function_names() const;

 private:
  std::vector<std::pair<std::string, ExpressionValue>> values_;
  std::vector<std::pair<std::string, Table>> tables_;
  std::vector<std::pair<std::string, std::string>> explanations_;
};

/// True if a text can be a name in expressions: letters, digits and '_', not starting with a digit.
bool is_expression_name(std::string_view text);

/// Suggests a replacement for a name, a function or a word operator of other languages; empty if
/// unknown.
std::string_view foreign_name_hint(std::string_view name);
std::string_view foreign_function_hint(std::string_view name);
std::string_view foreign_operator_hint(std::string_view word);

}  // namespace conddp
