#pragma once

#include <string>
#include <string_view>

#include "problem_file/yaml/yaml_node.hpp"

namespace conddp {

/// Whether a top-level key of a problem file is of the problem itself: not so are those that say
/// how it is solved or what it is called (name, description, initial_guess, perturbation, solver,
/// mpc).
bool is_of_the_problem(std::string_view key);

/// What a document says of the problem itself (is_of_the_problem), the same for whatever is written
/// another way: comments, the order of keys and the notation of numbers have no part in it.
std::string canonical_definition(const YamlNode& root);

/// The same of one value.
std::string canonical_value(const YamlNode& node);

}  // namespace conddp
