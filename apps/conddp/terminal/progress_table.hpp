#pragma once

#include "solvers/common/iteration_record.hpp"

namespace conddp {

/// On stderr one line an iteration, with a heading now and then.
class ProgressTable {
 public:
  void print(const IterationRecord& row);

 private:
  int lines_ = 0;
  double share_ = 1;     ///< of the way of a homotopy
  int restoration_ = 0;  ///< the restoration that rows are of, 0: none
};

}  // namespace conddp
