#pragma once

#include "problem_file/spec/spec_values.hpp"
#include "problem_file/yaml/yaml_reader.hpp"

namespace conddp {

std::optional<StateSpec> read_state(const YamlReader& reader);

}  // namespace conddp
