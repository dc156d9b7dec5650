#pragma once

#include <memory>
#include <string>
#include <vector>

#include "output/mpc/plant_rows.hpp"

namespace conddp {

/// What the rows of a plant say of themselves, and what its equations and its problem say of them.
struct PlantReplay {
  /// The largest distance of a row's state from where the plant gets from the row before: relative
  /// to what times of nine decimals allow. At most 1 where the rows follow the plant.
  double excess = 0;
  double deviation = 0;  ///< there, in the quantity's unit
  double allowed = 0;    ///< there
  std::string place;     ///< "0.24 s, v/hinge"; empty without rows that differ
  double cost = 0;
  double cost_rounding = 0;  ///< of it, by the decimals of the times
  double violation = 0;
  /// The end that the last row shows: a state that meets a condition or is not finite, or the time.
  LoopEnd end = LoopEnd::finished;
  bool goes_on_after_end = false;  ///< a row before the last one should have ended the loop
};

/// Moves the plant of a loop from each row to the next by its control, without the controller.
PlantReplay replay_plant(const PlantRows& rows, const LoopTask& task);

}  // namespace conddp
