#pragma once

#include <filesystem>
#include <vector>

#include "problem_file/yaml/yaml_node.hpp"

namespace conddp {

/// The cells of some columns of a CSV file with a header, row by row: numbers, lists and mappings
/// as in a problem file (`"[0.3, 0.4]"`, whose commas ask for quotes), else texts. An unknown
/// column is reported where it is named, a bad row in the file, a file that cannot be read at
/// `place`; then there are no rows.
std::vector<std::vector<YamlNode>> read_axis_table(const std::filesystem::path& file,
                                                   const Place& place,
                                                   const std::vector<Name>& columns,
                                                   Diagnostics& out);

}  // namespace conddp
