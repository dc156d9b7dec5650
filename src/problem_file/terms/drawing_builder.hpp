#pragma once

#include <string>

#include "problem_file/model/spec_draw.hpp"
#include "problem_file/terms/constraint_builder.hpp"

namespace conddp {

/// An expression of a drawing.
struct DrawnText {
  const char* key;   ///< of the file
  std::string name;  ///< unique among all drawings: "car/at"
  const ExpressionText* text;
};
/// Place, angle and corners of a drawing, as far as it has them.
std::vector<DrawnText> drawn_texts(const DrawingSpec& drawing);

/// The expressions of drawings as constraints without meaning, whose values are their numbers.
std::vector<ConstraintSpec> drawn_constraints(const std::vector<DrawingSpec>& drawings);

/// Builds these constraints, which hold at the last node if it has what they read. Reports
/// expressions with too many or too few numbers.
std::vector<BuiltConstraint> build_drawn(const std::vector<ConstraintSpec>& drawn,
                                         const CostContext& context, Diagnostics& out);

}  // namespace conddp
