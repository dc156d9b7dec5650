#pragma once

#include <functional>
#include <string>
#include <vector>

#include "flow_text.hpp"
#include "systems/system.hpp"

namespace conddp {

/// What moves in composed problems: how a file says it, and what can be named of it.
struct ComposedBody {
  struct Foot {
    std::string contact, frame;
    bool sole = false;  ///< more often a surface than anything else
  };

  std::string name;  ///< the type of a closed-form system, or what the robot is called here
  /// The lines of the file that say what moves and what it may touch, with random figures.
  std::function<std::string(RandomNumbers&)> text;
  Entries initial_state;   ///< keys of the state in which it stands
  std::vector<Foot> feet;  ///< what may be a contact of phases
  Entries shapes = {};     ///< names of its shapes, an obstacle among them
  bool stepping = false;   ///< steps are contact-implicit
  bool walks = false;      ///< its feet are those of a gait
  bool floating = false;
  int most_knots = 10;

  // What the tool itself says of it, from a problem with nothing but it (learn).
  bool robot = false;
  bool curved = false;  ///< some of its state is a rotation in space
  SystemKind kind = SystemKind::second_order;
  /// Whether it has coordinates that stand alone, and limits of them in its URDF, among its
  /// positions and its velocities.
  bool positions = false, velocities = false, limited_positions = false, limited_velocities = false;
  Entries columns;   ///< coordinates of the state that stand alone
  Entries controls;  ///< of the actuators
  Entries joints;    ///< with a coordinate of their own
  Entries frames;
};

/// Every type of closed-form system, and robots of problems/ with every kind of base.
const std::vector<ComposedBody>& composed_bodies();

}  // namespace conddp
