#pragma once

#include <vector>

#include "problem_file/model/spec_solver.hpp"
#include "problem_file/values/key_forms.hpp"

namespace conddp {

void describe(Keys& keys, HomotopyKeySpec& moved);

/// The list `solver.homotopy` of a problem file.
struct HomotopyForm : MapsForm {
  bool read(const YamlReader& reader, std::vector<HomotopyKeySpec>& keys) const;
  /// The numbers that move are known once the problem is built.
  std::optional<OrderedJson> expand(const std::vector<HomotopyKeySpec>& /*keys*/) const {
    return std::nullopt;
  }
};

/// Sets the numbers of a document's homotopy, if any, to their values at `share` of the path. The
/// path is from (to/from)^share if both have the same sign, else from + share (to − from). Reports
/// keys without a parent in the document and keys of values that are not numbers. A malformed list
/// is left to the reader.
void place_homotopy(YamlNode& root, double share, Diagnostics& out);

}  // namespace conddp
