#pragma once

#include "problem_file/spec/spec_expression.hpp"
#include "problem_file/yaml/yaml_reader.hpp"

namespace conddp {

/// The constants under `parameters` of a document: numbers, lists of numbers, and expressions of
/// those before them, `=2*mass`. Every value of the document that begins with '=' is replaced by
/// what it gives: a number, or the list of a vector. `name` and `description` are left alone. Free
/// parameters, mappings, become states of the document's systems or robots (place_free_parameters).
/// `=load` alone, with a free parameter, is replaced by its name where the masses of payloads are.
ExpressionNamesSpec place_parameters(YamlNode& root, Diagnostics& out);

}  // namespace conddp
