#pragma once

#include "problem_file/spec/spec_values.hpp"
#include "problem_file/yaml/yaml_reader.hpp"

namespace conddp {

std::optional<StateSpec> read_state(const YamlReader& reader);
/// Reads the keys of a state in a mapping that also has other keys.
StateSpec read_state_keys(YamlMap& map);

}  // namespace conddp
