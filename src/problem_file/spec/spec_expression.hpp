#pragma once

#include <memory>
#include <string>
#include <vector>

#include "base/diagnostic.hpp"

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
  std::string name;
  std::vector<std::vector<double>> points;
  std::vector<double> values;
};

}  // namespace conddp
