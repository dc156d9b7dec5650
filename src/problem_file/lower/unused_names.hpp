#pragma once

#include "problem_file/yaml/yaml_node.hpp"

namespace conddp {

/// Warns of unused names in the document: free parameters, tables, definitions ('let'), named
/// residuals ('of') and named systems. Constants are exempt: other versions of the file may need
/// them.
void warn_of_unused_names(const YamlNode& root, Diagnostics& out);

}  // namespace conddp
