#pragma once

#include <string>
#include <vector>

#include "output/mpc/loop_task.hpp"

namespace conddp {

/// The rows of a closed_loop.csv. Empty cells are NaN.
struct PlantRows {
  std::vector<double> times;           ///< s, with nine decimals
  std::vector<std::vector<double>> x;  ///< one per time
  std::vector<std::vector<double>> u;  ///< one per time; NaN for the last
};

/// Parses the text of a closed_loop.csv. Throws MalformedSolution, with the line, if it does not
/// belong to this loop.
PlantRows read_plant_rows(const std::string& text, const LoopTask& task);

}  // namespace conddp
