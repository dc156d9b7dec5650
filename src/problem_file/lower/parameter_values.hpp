#pragma once

#include "problem_file/model/spec_expression.hpp"
#include "problem_file/yaml/yaml_reader.hpp"

namespace conddp {

/// Reads the constants under `parameters` of a document: numbers, lists of numbers, and expressions
/// of preceding constants, `=2*mass`. Replaces every value of the document that begins with '=' by
/// its result: a number, or the list of a vector. `name` and `description` are unchanged. Free
/// parameters, which are mappings, become states of the document's systems or robots
/// (place_free_parameters). A payload's mass `=load` with a free parameter `load` becomes its name.
ExpressionNamesSpec place_parameters(YamlNode& root, Diagnostics& out);

}  // namespace conddp
