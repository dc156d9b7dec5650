#pragma once

#include <vector>

#include "problem_file/model/spec_solver.hpp"
#include "problem_file/yaml/yaml_reader.hpp"

namespace conddp {

/// Reads the list `solver.homotopy` of a problem file.
std::vector<HomotopyKeySpec> read_homotopy(const YamlReader& reader);

/// Sets the numbers of a document's homotopy, if any, to their values at `share` of the path. The
/// path is from (to/from)^share if both have the same sign, else from + share (to − from). Reports
/// keys without a parent in the document and keys of values that are not numbers. A malformed list
/// is left to read_homotopy.
void place_homotopy(YamlNode& root, double share, Diagnostics& out);

}  // namespace conddp
