#pragma once

#include <string_view>
#include <vector>

#include "problem_file/spec/residual_definition.hpp"
#include "problem_file/spec/spec_expression.hpp"

namespace conddp {

namespace key {

/// The factors of a row by column; `constant` is added.
inline const Key<std::vector<NamedNumbers>> combination_rows{"rows"};
inline const Key<ExpressionRowsSpec> expression_rows{"rows"};

}  // namespace key

/// The name of the preceding knot's control in expressions, indexed by component.
inline constexpr std::string_view kPreviousControl = "previous";

/// The rows of a combination as factors, or of a residual as expressions.
const ResidualKey& rows_key();

}  // namespace conddp
