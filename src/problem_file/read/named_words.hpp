#pragma once

#include <string>
#include <utility>
#include <vector>

#include "problem_file/yaml/yaml_reader.hpp"

namespace conddp {

/// Names with a word each, such as a unit: of a mapping, or of a list, where the word is 1.
std::vector<std::pair<Name, std::string>> read_named_words(const YamlReader& reader);

}  // namespace conddp
