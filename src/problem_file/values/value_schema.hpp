#pragma once

#include <string_view>

#include "base/json/ordered_json.hpp"
#include "problem_file/yaml/yaml_reader.hpp"

namespace conddp {

/// JSON Schema of values: parts of schemas/problem.schema.json.

OrderedJson range_schema(const NumberRange& range);
/// A reference to one of its definitions.
OrderedJson defined_schema(std::string_view definition);

}  // namespace conddp
