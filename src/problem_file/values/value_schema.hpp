#pragma once

#include <string_view>

#include "base/json/ordered_json.hpp"
#include "problem_file/yaml/yaml_reader.hpp"

namespace conddp {

/// JSON Schema of values: parts of schemas/problem.schema.json.

OrderedJson range_schema(const NumberRange& range);
/// What one of its definitions describes.
OrderedJson defined_schema(std::string_view definition);

}  // namespace conddp
