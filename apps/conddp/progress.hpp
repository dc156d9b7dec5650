#pragma once

#include <cstdio>
#include <string>

#include "output/solution.hpp"
#include "solvers/iteration_record.hpp"

namespace conddp {

/// One line an iteration, with a heading now and then.
class ProgressTable {
 public:
  explicit ProgressTable(std::FILE* stream) : stream_(stream) {}
  void print(const IterationRecord& row);

 private:
  std::FILE* stream_;
  int lines_ = 0;
};

/// How a solve ended, for people. `colour`: the status in green or yellow; `notes`: how many notes
/// about the input were not shown.
std::string summary_text(const Solution& solution, const std::vector<std::string>& written,
                         bool colour, int notes);

}  // namespace conddp
