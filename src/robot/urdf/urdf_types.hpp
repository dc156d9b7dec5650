#pragma once

#include <map>
#include <optional>
#include <string>
#include <vector>

#include "robot/model.hpp"

namespace conddp {

/// Error or warning about a URDF or about the options for reading it.
struct UrdfProblem {
  std::string message;       ///< a sentence that names the link or joint
  std::string element = {};  ///< name of the link or joint; empty for the whole file
  int line = 0;              ///< 1-based; 0 if the problem has no place in the file
  int column = 0;            ///< 1-based, in characters
  std::string hint = {};     ///< a remedy; may be empty
  bool warning = false;      ///< true: the model is built anyway
};

/// Options for building a model. Names are those of the file, without `prefix`.
struct UrdfOptions {
  /// Connection of the root link to the world. `floating` adds a six-DoF joint named "base", whose
  /// q is (position, quaternion x y z w); `planar` adds base_x, base_y and base_yaw. If the file
  /// has a joint of that name, an underscore is appended. `fixed` accepts a floating or planar
  /// joint in the file if its parent is the root link or rigid with it.
  enum class Base { fixed, floating, planar } base = Base::fixed;
  /// Positions (rad or m) of joints to merge like fixed ones. `*` in a name matches any letters.
  std::map<std::string, double> locked_joints = {};
  /// A body carried rigidly by a link.
  struct Payload {
    std::string link = {};
    double mass = 0;                                 ///< kg
    Vector3<double> com = Vector3<double>::zero();   ///< in the link's frame, m
    std::optional<Symmetric3<double>> inertia = {};  ///< about the com, link axes; absent: a point
  };
  std::vector<Payload> payloads = {};
  /// Reflected inertia of the motor's rotor (kg m², or kg for a prismatic joint). `*` in a name
  /// matches any letters.
  std::map<std::string, double> rotor_inertia = {};
  /// True if mimic joints follow their leader and are locked with it. Otherwise they are
  /// independent joints, and a note lists them.
  bool enforce_mimic = false;
  /// Treatment of a link's inertia that is not physically valid (a principal moment is negative or
  /// exceeds the sum of the others). `as_given`: a warning, and an error only if the joint-space
  /// inertia matrix is not positive definite. `strict`: an error.
  enum class Inertias { as_given, strict } inertias = Inertias::as_given;
  Vector3<double> gravity{0, 0, -9.81};
  /// Prefix of every joint and frame name, e.g. "left/"; for several trees in one problem.
  std::string prefix = {};
  /// Pose of the root link (fixed base) or of the plane (planar base) in the world.
  std::optional<SE3<double>> placement = {};
};

struct UrdfResult {
  std::optional<RobotModel> model;    ///< absent if any problem is an error
  std::vector<UrdfProblem> problems;  ///< errors and warnings, sorted by line
  std::vector<std::string> notes;     ///< remarks, e.g. on content that the model ignores
  std::string text;                   ///< bytes of the file; set by load_urdf
};

}  // namespace conddp
