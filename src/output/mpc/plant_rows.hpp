#pragma once

#include <string>
#include <vector>

#include "output/mpc/loop_task.hpp"

namespace conddp {

/// The rows of a closed_loop.csv. What is empty there is not a number.
struct PlantRows {
  std::vector<double> times;           ///< s, with nine decimals
  std::vector<std::vector<double>> x;  ///< one a time
  std::vector<std::vector<double>> u;  ///< one a time; of the last one not a number
};

/// Reads the text of a closed_loop.csv. Throws MalformedSolution, with the line, where it is none
/// of this loop.
PlantRows read_plant_rows(const std::string& text, const LoopTask& task);

}  // namespace conddp
