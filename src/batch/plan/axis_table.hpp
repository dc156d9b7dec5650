#pragma once

#include <filesystem>
#include <vector>

#include "problem_file/yaml/yaml_node.hpp"

namespace conddp {

/// The cells of some columns of a CSV file with a header, row by row. Cells are numbers, lists and
/// mappings as in a problem file, or texts; commas in lists need quotes (`"[0.3, 0.4]"`). Returns
/// no rows after an error. An unknown column is reported where it is named, a bad row in the file,
/// an unreadable file at `place`.
std::vector<std::vector<YamlNode>> read_axis_table(const std::filesystem::path& file,
                                                   const Place& place,
                                                   const std::vector<Name>& columns,
                                                   Diagnostics& out);

}  // namespace conddp
