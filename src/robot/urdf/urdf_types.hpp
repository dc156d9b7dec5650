#pragma once

#include <map>
#include <optional>
#include <string>
#include <vector>

#include "robot/model.hpp"

namespace conddp {

/// What is wrong, or doubtful, in a URDF or in what was asked of it.
struct UrdfProblem {
  std::string message;       ///< a sentence that names the link or joint
  std::string element = {};  ///< the link's or joint's name alone, empty for the whole file
  int line = 0;              ///< 1-based, 0 where the problem has no place in the file
  int column = 0;            ///< 1-based, in characters
  std::string hint = {};     ///< what to do about it, may be empty
  bool warning = false;      ///< the model is built all the same
};

/// How a URDF becomes a model. Names are those of the file, without `prefix`.
struct UrdfOptions {
  /// How the root link meets the world. `floating` adds a six-DoF joint named "base" with q =
  /// (position, quaternion x y z w); `planar` adds base_x, base_y and base_yaw. Where the file has
  /// a joint of such a name, an underscore is appended. A floating or planar joint of the file
  /// whose parent is the root (or rigid with it) is accepted with `fixed`.
  enum class Base { fixed, floating, planar } base = Base::fixed;
  /// Joints merged like fixed ones at a value (rad or m). Names may have `*` for any letters.
  std::map<std::string, double> locked_joints = {};
  /// A body carried rigidly by a link.
  struct Payload {
    std::string link = {};
    double mass = 0;                                 ///< kg
    Vector3<double> com = Vector3<double>::zero();   ///< in the link's frame, m
    std::optional<Symmetric3<double>> inertia = {};  ///< about the com, link axes; absent: a point
  };
  std::vector<Payload> payloads = {};
  /// Inertia of the motor's rotor reflected to the joint (kg m², or kg for a prismatic joint).
  /// Names may have `*`.
  std::map<std::string, double> rotor_inertia = {};
  /// Whether mimic joints follow their leader, and are locked with it; otherwise they are
  /// independent, with a note.
  bool enforce_mimic = false;
  /// What becomes of a link's inertia that is not physically valid (a principal moment that is
  /// negative or exceeds the sum of the others). `as_given`: a warning, and an error only where the
  /// joint-space inertia matrix is not positive definite. `strict`: an error.
  enum class Inertias { as_given, strict } inertias = Inertias::as_given;
  Vector3<double> gravity{0, 0, -9.81};
  /// Put before every joint's and frame's name, e.g. "left/": for several trees in one problem.
  std::string prefix = {};
  /// Where the root link (fixed base) or the plane (planar base) stands in the world.
  std::optional<SE3<double>> placement = {};
};

struct UrdfResult {
  std::optional<RobotModel> model;    ///< absent if any problem is an error
  std::vector<UrdfProblem> problems;  ///< errors and warnings by line
  std::vector<std::string> notes;     ///< what the file has and the model ignores
  std::string text;                   ///< the file's bytes, of load_urdf
};

}  // namespace conddp
