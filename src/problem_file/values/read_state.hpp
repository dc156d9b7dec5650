#pragma once

#include "problem_file/spec/spec_values.hpp"
#include "problem_file/yaml/yaml_reader.hpp"

namespace conddp {

std::optional<StateSpec> read_state(const YamlReader& reader);
/// The keys of a state inside a mapping that has others as well.
StateSpec read_state_keys(YamlMap& map);

}  // namespace conddp
