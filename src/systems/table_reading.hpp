#pragma once

#include <cmath>
#include <string>

namespace conddp {

/// Where a table of values is read by one of its arguments. Not-a-number where that is not known.
struct TableReading {
  std::string table;
  double at = 0;
  double first = 0, last = 0;  ///< the points of the table at the ends

  /// How far beyond its points, 0 between them.
  double beyond() const {
    if (std::isnan(at)) return 0;
    return at < first ? first - at : at > last ? at - last : 0;
  }
};

}  // namespace conddp
