#pragma once

#include <functional>
#include <string>
#include <vector>

#include "flow_text.hpp"
#include "systems/system.hpp"

namespace conddp {

/// System of a composed problem: its text in a file and its names.
struct ComposedBody {
  struct Foot {
    std::string contact, frame;
    bool sole = false;  ///< usually a surface
  };

  std::string name;  ///< type of a closed-form system, or a name for the robot
  /// File lines that describe the system and its contacts, with random numbers.
  std::function<std::string(RandomNumbers&)> text;
  Entries initial_state;   ///< state keys of the standing posture
  std::vector<Foot> feet;  ///< possible contacts of phases
  Entries shapes = {};     ///< names of its shapes, including an obstacle
  bool stepping = false;   ///< contact-implicit steps
  bool walks = false;      ///< feet usable in a gait
  bool floating = false;
  int most_knots = 10;

  // Properties that `learn` queries from the tool.
  bool robot = false;
  bool curved = false;  ///< part of the state is a spatial rotation
  SystemKind kind = SystemKind::second_order;
  /// Scalar coordinates among positions and velocities, and URDF limits on them.
  bool positions = false, velocities = false, limited_positions = false, limited_velocities = false;
  Entries columns;   ///< scalar coordinates of the state
  Entries controls;  ///< of the actuators
  Entries joints;    ///< with a coordinate of their own
  Entries frames;
};

/// Every type of closed-form system, and robots of problems/ with every kind of base.
const std::vector<ComposedBody>& composed_bodies();

}  // namespace conddp
