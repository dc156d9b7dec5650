#pragma once

#include <memory>
#include <string>
#include <vector>

#include "base/text/diagnostic.hpp"
#include "systems/expressions/model_texts.hpp"

namespace conddp {

/// An expression as it stands in the file.
struct ExpressionText {
  std::string text;
  Place place;
  bool quoted = false;  ///< or a block scalar
};

/// Rows of a residual in words.
struct ExpressionRowsSpec {
  std::vector<ExpressionText> texts;
  std::vector<std::string> names;  ///< one a text; empty: rows are numbered from 1
};

/// Tabulated data of expressions: grid points of one or two arguments, and the values, those of the
/// last argument one after the other.
struct TableSpec {
  Name name;
  std::vector<std::vector<double>> points;
  std::vector<double> values;
  std::shared_ptr<const SplineTable> function;  ///< through them
};

/// Constants and tables with names that expressions know.
struct ExpressionNamesSpec {
  NamedParameters parameters;
  std::vector<Place> parameter_places;
  std::vector<TableSpec> tables;
  /// Whether some could not be read, so that expressions would stumble over what is missing.
  bool incomplete = false;
};

/// Adds them to those of a text.
void add_names(const ExpressionNamesSpec& names, NamedParameters& parameters, NamedTables& tables);

}  // namespace conddp
