#pragma once

#include <string>

#include "base/json/ordered_json.hpp"

namespace conddp {

/// The meaning of the solver name `auto`.
extern const std::string_view kAutoMeaning;

/// The JSON Schema of problem files.
OrderedJson problem_schema();

/// A schema as text: what fits on a line stands on one line.
std::string schema_text(const OrderedJson& schema);

}  // namespace conddp
