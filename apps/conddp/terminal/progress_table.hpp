#pragma once

#include "solvers/common/iteration_record.hpp"

namespace conddp {

/// Prints one line per iteration to stderr, with an occasional heading.
class ProgressTable {
 public:
  void print(const IterationRecord& row);

 private:
  int lines_ = 0;
  double share_ = 1;     ///< of the homotopy
  int restoration_ = 0;  ///< restoration of the current rows, 0: none
};

}  // namespace conddp
