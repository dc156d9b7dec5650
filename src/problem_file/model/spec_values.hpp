#pragma once

#include <algorithm>
#include <optional>
#include <string_view>
#include <utility>
#include <vector>

#include "base/text/diagnostic.hpp"
#include "spatial/se3.hpp"

namespace conddp {

/// Numbers by name, in the order of the file.
using NamedNumbers = std::vector<std::pair<Name, double>>;

/// Values of the components of a vector: one number for all, a list with one entry per component
/// (null: no value), or a mapping from component names to numbers. The names may contain `*`.
struct ComponentsSpec {
  enum class Form { kScalar, kList, kMap };
  Place place;
  Form form = Form::kScalar;
  std::optional<double> scalar;
  std::vector<std::optional<double>> list;
  std::vector<std::pair<Name, std::optional<double>>> map;
};

/// A symmetric matrix on the components of a vector. It is given by its rows, complete or up to the
/// diagonal, or by entries named by row and column; each entry includes its mirror image.
struct MatrixSpec {
  Place place;
  std::vector<Located<std::vector<double>>> rows;
  std::vector<std::pair<Name, NamedNumbers>> entries;
};

/// Contacts by name, or all contacts.
struct ContactNames {
  bool all = false;
  std::vector<Name> names;

  bool any() const { return all || !names.empty(); }
  bool has(std::string_view name) const {
    return all || std::any_of(names.begin(), names.end(),
                              [name](const Name& own) { return own.value == name; });
  }
};

/// A knot or node: its number or, before the rewriting `gait`, that from the first knot of a phase.
struct KnotSpec {
  int value = 0;
  Place place;
  std::string phase;
};

/// A placement in the world, or the given parts of it.
struct PoseSpec {
  Place place;
  std::optional<Vector3<double>> position;        ///< m
  std::optional<Quaternion<double>> orientation;  ///< unit

  /// Missing parts take the world's origin and axes.
  SE3<double> placement() const {
    SE3<double> placement = SE3<double>::identity();
    if (position) placement.p = *position;
    if (orientation) placement.R = rotation_matrix(*orientation);
    return placement;
  }
};

/// A velocity: linear m/s, angular rad/s.
struct TwistSpec {
  Place place;
  Vector3<double> linear = Vector3<double>::zero();
  Vector3<double> angular = Vector3<double>::zero();
};

/// Pose of a floating base, or the place of a planar one.
struct BaseSpec {
  Place place;
  std::optional<std::vector<double>> position;    ///< three numbers, two for a planar base
  std::optional<Quaternion<double>> orientation;  ///< floating
};

/// A motion of a base in the horizontal plane: forward and left in its initial heading (m), and a
/// turn about its origin (rad). It may also rise.
struct PlanarMotion {
  double x = 0, y = 0, yaw = 0;
  double rise = 0;  ///< m
};

/// Displacement of a base: by a motion, or as the file's gait moves it.
struct DisplacementSpec {
  Place place;
  bool with_gait = false;
  PlanarMotion motion;
};

/// A frame and its placement in a state.
struct PlacedFrame {
  Name name;
  PoseSpec pose;
};

struct NamedState;

/// A state in one of the notations of a file. Missing values are neutral: zero, no rotation, at
/// rest.
struct StateSpec {
  Place place;
  std::optional<Name> configuration;
  std::optional<BaseSpec> base;
  /// Displacement of the base that the preceding keys place.
  std::optional<DisplacementSpec> displaced;
  NamedNumbers joints;
  /// Joint positions follow from these, and are near those of the preceding keys.
  std::vector<PlacedFrame> frames;
  std::optional<TwistSpec> base_velocity;
  NamedNumbers joint_velocities;
  /// Several robots: the state of each by name.
  std::vector<NamedState> robots;
  /// All numbers of the state.
  std::optional<std::vector<double>> state;
  /// By column name.
  NamedNumbers values;
  /// Only in problems that use the control rate.
  std::optional<ComponentsSpec> previous_control;
};

struct NamedState {
  Name name;
  StateSpec state;
};

}  // namespace conddp
