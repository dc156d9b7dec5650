#pragma once

#include <cmath>
#include <string>

namespace conddp {

/// The point at which a table is read along one of its arguments. NaN if unknown.
struct TableReading {
  std::string table;
  double at = 0;
  double first = 0, last = 0;  ///< first and last grid point

  /// Distance outside the range of the grid points; 0 within it.
  double beyond() const {
    if (std::isnan(at)) return 0;
    return at < first ? first - at : at > last ? at - last : 0;
  }
};

}  // namespace conddp
