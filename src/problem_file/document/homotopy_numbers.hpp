#pragma once

#include <vector>

#include "problem_file/spec/spec_solver.hpp"
#include "problem_file/yaml/yaml_reader.hpp"

namespace conddp {

/// The list `solver.homotopy` of a problem file.
std::vector<HomotopyKeySpec> read_homotopy(const YamlReader& reader);

/// Puts the numbers that the homotopy of a document moves, if it has one, where they are at a share
/// of the way: from (to/from)^share where both have one sign, else from + share (to − from). A key
/// whose parent the document has not, or that leads to something else than a number, is reported. A
/// malformed list is left to read_homotopy.
void place_homotopy(YamlNode& root, double share, Diagnostics& out);

}  // namespace conddp
