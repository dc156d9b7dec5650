#pragma once

#include <memory>
#include <string>
#include <vector>

#include "base/text/diagnostic.hpp"
#include "systems/expressions/model_texts.hpp"

namespace conddp {

/// An expression as written in the file.
struct ExpressionText {
  std::string text;
  Place place;
  bool quoted = false;  ///< or a block scalar
};

/// Rows of an expression residual.
struct ExpressionRowsSpec {
  std::vector<ExpressionText> texts;
  std::vector<std::string> names;  ///< one per text; empty: rows are numbered from 1
};

/// Tabulated data of expressions: grid points of one or two arguments, and the values. The last
/// argument varies fastest.
struct TableSpec {
  Name name;
  std::vector<std::vector<double>> points;
  std::vector<double> values;
  std::shared_ptr<const SplineTable> function;  ///< spline through the values
};

/// A parameter that the solver optimizes within bounds.
struct FreeParameter {
  Name name;
  double lower = 0, upper = 0, start = 0;
};

/// Named constants and tables of expressions.
struct ExpressionNamesSpec {
  NamedParameters parameters;
  std::vector<Place> parameter_places;
  std::vector<FreeParameter> free;
  std::vector<TableSpec> tables;
  /// True if some entries could not be read; missing names then cause no further errors.
  bool incomplete = false;
};

/// Adds them to the names of a text.
void add_names(const ExpressionNamesSpec& names, NamedParameters& parameters, NamedTables& tables);

}  // namespace conddp
