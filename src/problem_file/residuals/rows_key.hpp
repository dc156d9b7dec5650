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

/// The name under which expressions know the control of the knot before, by its components.
inline constexpr std::string_view kPreviousControl = "previous";

/// The rows of a combination, in factors, or of a residual in expressions.
const ResidualKey& rows_key();

}  // namespace conddp
