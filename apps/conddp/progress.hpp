#pragma once

#include <string>
#include <vector>

#include "output/report/solution_certificate.hpp"
#include "output/solution/solution.hpp"
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

/// How a solve ended, for people. `certificate` may be null; `colour`: the status in green or
/// yellow; `notes`: how many notes about the input were not shown. In the form of terminal_text.
std::string summary_text(const Solution& solution, const SolutionCertificate* certificate,
                         const std::vector<std::string>& written, bool colour, int notes);

}  // namespace conddp
