#pragma once

#include <memory>
#include <string>
#include <vector>

#include "output/mpc/plant_rows.hpp"

namespace conddp {

/// Comparison of a plant's rows with its equations and its problem.
struct PlantReplay {
  /// The largest distance between a row's state and the step from the row before, relative to the
  /// tolerance that times of nine decimals imply. At most 1 if the rows follow the plant.
  double excess = 0;
  double deviation = 0;  ///< at that row, in the quantity's unit
  double allowed = 0;    ///< at that row
  std::string place;     ///< "0.24 s, v/hinge"; empty without rows that differ
  double cost = 0;
  double cost_rounding = 0;  ///< of the cost, from the decimals of the times
  double violation = 0;
  /// End indicated by the last row: a state that meets a stop condition or is not finite, or the
  /// final time.
  LoopEnd end = LoopEnd::finished;
  bool goes_on_after_end = false;  ///< an earlier row should have ended the loop
};

/// Steps the plant of a loop from each row to the next with the row's control, without the
/// controller.
PlantReplay replay_plant(const PlantRows& rows, const LoopTask& task);

}  // namespace conddp
