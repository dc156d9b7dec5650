#include "problem_file/values/value_schema.hpp"

#include <cmath>
#include <string>

namespace conddp {

OrderedJson range_schema(const NumberRange& range) {
  OrderedJson schema = {{"type", "number"}};
  if (std::isfinite(range.lower))
    schema[range.lower_open ? "exclusiveMinimum" : "minimum"] = range.lower;
  if (std::isfinite(range.upper))
    schema[range.upper_open ? "exclusiveMaximum" : "maximum"] = range.upper;
  return schema;
}

OrderedJson defined_schema(std::string_view definition) {
  const OrderedJson link = {{"$ref", "#/definitions/" + std::string(definition)}};
  return {{"allOf", OrderedJson::array({link})}};
}

}  // namespace conddp
