#pragma once

#include <string>
#include <string_view>
#include <vector>

#include "problem_file/yaml/yaml_reader.hpp"

namespace conddp {

/// A parameter of a file that the solver chooses within bounds.
struct FreeParameter {
  Name name;
  double lower = 0, upper = 0, start = 0;
};

/// Reads `{free: true, lower: 0.5, upper: 2, start: 1}`; without `start` it is the middle. Nothing
/// with an error.
std::optional<FreeParameter> read_free_parameter(const Name& name, const YamlReader& reader);

/// Whether a path of a document leads to the mass of a payload.
bool is_mass_of_payload(std::string_view path);
/// What is accepted in the place of a formula of free parameters at a path.
std::string hint_of_free_parameter(std::string_view path);

/// Writes free parameters into a document as what they are: states that stay as they are and are
/// chosen at the beginning. Each becomes a state of every system, with the rate 0 or itself as next
/// value, and starts in the initial state; or a parameter of every robot of which a payload has its
/// name as mass, of the first one where none has. It is a coordinate of the first phase, which
/// chooses. Reports what excludes free parameters.
void place_free_parameters(const std::vector<FreeParameter>& parameters, YamlNode& root,
                           Diagnostics& out);

}  // namespace conddp
