#pragma once

#include "problem_file/yaml/yaml_node.hpp"

namespace conddp {

/// Warns of free parameters, tables, definitions ('let'), named residuals ('of') and named systems
/// that nothing in the document uses. Constants may be there for other versions of a file.
void warn_of_unused_names(const YamlNode& root, Diagnostics& out);

}  // namespace conddp
