#pragma once

#include "problem_file/plant/plant.hpp"

namespace conddp {

/// A frame that a state places.
struct WantedFrame {
  PlacedFrame placed;
  std::string prefix;  ///< of its robot's names
};

/// The frames that a state and its configurations place; of two entries for one frame the outer
/// one. Names must be known. `part`: the robot of the state, or all of them.
std::vector<WantedFrame> wanted_frames(const StateSpec& state, const PlantPart& part,
                                       const Plant& plant);

/// Moves joints of all robots, bases excepted, until the frames have their placements
/// (find_posture(), with Plant::kept). A placement that was not reached is an error
/// that tells by how much the frame, loops and shapes miss their goals; x then is unchanged. `x`: a
/// state of the system.
void place_frames(const std::vector<WantedFrame>& frames, const Plant& plant,
                  std::vector<double>& x, Diagnostics& out);

}  // namespace conddp
