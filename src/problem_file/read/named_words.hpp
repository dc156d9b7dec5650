#pragma once

#include <string>
#include <utility>
#include <vector>

#include "problem_file/yaml/yaml_reader.hpp"

namespace conddp {

/// Names with a word each, such as a unit: from a mapping, or from a list, with the word 1.
std::vector<std::pair<Name, std::string>> read_named_words(const YamlReader& reader);

}  // namespace conddp
