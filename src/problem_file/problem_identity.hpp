#pragma once

#include <string>

#include "problem_file/build.hpp"
#include "problem_file/yaml_node.hpp"

namespace conddp {

/// What a document says of the problem itself, the same for whatever is written another way:
/// comments, the order of keys and the notation of numbers have no part in it, nor have the keys
/// that say how it is solved or what it is called (name, description, initial_guess, perturbation,
/// solver).
std::string canonical_definition(const YamlNode& root);

/// The SHA-256 of a problem, unperturbed and with all its constraints: of what its file and the
/// settings say of it (ProblemSpec::definition), and of the files with its robots and data.
std::string problem_sha256(const ProblemSpec& spec, const BuiltProblem& built);

}  // namespace conddp
