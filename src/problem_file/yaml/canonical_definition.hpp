#pragma once

#include <string>
#include <string_view>

#include "base/json/ordered_json.hpp"
#include "problem_file/yaml/yaml_node.hpp"

namespace conddp {

/// True for top-level keys that define the problem itself. Keys of its solution, naming or drawing
/// are excluded: name, description, initial_guess, perturbation, solver, mpc, draw.
bool is_of_the_problem(std::string_view key);

/// Canonical text of the part of a document that defines the problem (is_of_the_problem). Comments,
/// the order of keys and the notation of numbers do not affect it.
std::string canonical_definition(const YamlNode& root);

/// A document as JSON, with the keys in their order.
OrderedJson json_of(const YamlNode& node);

/// Canonical text of a single value.
std::string canonical_value(const YamlNode& node);

}  // namespace conddp
