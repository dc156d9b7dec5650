#pragma once

#include <string>
#include <vector>

#include "problem_file/assemble/build.hpp"

namespace conddp {

/// A number that the solver chose beside the motion: a free duration or parameter.
struct FreeNumber {
  std::string name;  ///< "duration/<phase>", or that of the parameter
  double value = 0;
  std::string unit;
  std::string limit;  ///< "lower" or "upper" if its limit holds it, else empty

  bool operator==(const FreeNumber&) const = default;
};

/// The free durations in the order of the phases, then the free parameters in that of the file.
std::vector<FreeNumber> free_numbers(const BuiltProblem& built, const Trajectory& trajectory);

}  // namespace conddp
