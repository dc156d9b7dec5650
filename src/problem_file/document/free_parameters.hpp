#pragma once

#include <string>
#include <string_view>
#include <vector>

#include "problem_file/yaml/yaml_reader.hpp"

namespace conddp {

/// A parameter of a file that the solver optimizes within bounds.
struct FreeParameter {
  Name name;
  double lower = 0, upper = 0, start = 0;
};

/// Reads `{free: true, lower: 0.5, upper: 2, start: 1}`; `start` defaults to the middle of the
/// bounds. Returns nothing with an error.
std::optional<FreeParameter> read_free_parameter(const Name& name, const YamlReader& reader);

/// True if a path of a document leads to the mass of a payload.
bool is_mass_of_payload(std::string_view path);
/// Hint about the values accepted at a path in place of a formula of free parameters.
std::string hint_of_free_parameter(std::string_view path);

/// Rewrites free parameters of a document as constant states with an optimized initial value. Each
/// becomes a state of every system, with rate 0 or itself as next value, and gets its start in the
/// initial state. With robots it becomes a parameter of every robot with a payload whose mass has
/// its name, otherwise of the first robot. The first phase, which chooses the initial state, gets
/// it as a coordinate. Reports features that exclude free parameters.
void place_free_parameters(const std::vector<FreeParameter>& parameters, YamlNode& root,
                           Diagnostics& out);

}  // namespace conddp
