#pragma once

#include <string>
#include <string_view>
#include <vector>

#include "problem_file/model/spec_expression.hpp"
#include "problem_file/values/key_forms.hpp"

namespace conddp {

void describe(Keys& keys, FreeParameter& parameter);
/// Reads `{free: true, lower: 0.5, upper: 2, start: 1}`; `start` defaults to the middle of the
/// bounds. Returns nothing with an error.
std::optional<FreeParameter> read_free_parameter(const Name& name, const YamlReader& reader);

/// True if a path of a document leads to the mass of a payload.
bool is_mass_of_payload(std::string_view path);
/// Hint about the values accepted at a path in place of a formula of free parameters.
std::string hint_of_free_parameter(std::string_view path);

/// Rewrites free parameters of a document as constant states. Each becomes a state of every system,
/// with rate 0 or itself as next value, and gets its start in the initial state. With robots it
/// becomes a parameter of every robot with a payload whose mass has its name, otherwise of the
/// first robot. choose_start lets the first phase choose their initial values. Reports features
/// that exclude free parameters.
void place_free_parameters(const std::vector<FreeParameter>& parameters, YamlNode& root,
                           Diagnostics& out);

}  // namespace conddp
