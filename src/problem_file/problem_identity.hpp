#pragma once

#include <string>
#include <string_view>

#include "problem_file/build.hpp"
#include "problem_file/yaml_node.hpp"

namespace conddp {

/// Whether a top-level key of a problem file is of the problem itself: not so are those that say
/// how it is solved or what it is called (name, description, initial_guess, perturbation, solver).
bool is_of_the_problem(std::string_view key);

/// What a document says of the problem itself (is_of_the_problem), the same for whatever is written
/// another way: comments, the order of keys and the notation of numbers have no part in it.
std::string canonical_definition(const YamlNode& root);

/// The SHA-256 of a problem, unperturbed and with all its constraints: of what its file and the
/// settings say of it (ProblemSpec::definition), and of the files with its robots and data.
std::string problem_sha256(const ProblemSpec& spec, const BuiltProblem& built);

}  // namespace conddp
