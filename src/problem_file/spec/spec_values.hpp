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

/// Values of the components of a vector: one number for all, a list with one entry a component
/// (null: none), or a mapping from component names to numbers. The names may have a `*`.
struct ComponentsSpec {
  enum class Form { kScalar, kList, kMap };
  Place place;
  Form form = Form::kScalar;
  std::optional<double> scalar;
  std::vector<std::optional<double>> list;
  std::vector<std::pair<Name, std::optional<double>>> map;
};

/// A symmetric matrix on the components of a vector: its rows, whole or up to the diagonal, or
/// entries by the names of their row and column, each of which stands for its mirror image too.
struct MatrixSpec {
  Place place;
  std::vector<Located<std::vector<double>>> rows;
  std::vector<std::pair<Name, NamedNumbers>> entries;
};

/// Contacts by name, or all that there are.
struct ContactNames {
  bool all = false;
  std::vector<Name> names;

  bool any() const { return all || !names.empty(); }
  bool has(std::string_view name) const {
    return all || std::any_of(names.begin(), names.end(),
                              [name](const Name& own) { return own.value == name; });
  }
};

/// A placement in the world, or the parts of one that were given.
struct PoseSpec {
  Place place;
  std::optional<Vector3<double>> position;        ///< m
  std::optional<Quaternion<double>> orientation;  ///< unit

  /// With the world's origin and axes for what was not given.
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

/// Where a floating or planar base is. A planar one has x, y and yaw.
struct BaseSpec {
  Place place;
  std::optional<std::vector<double>> position;    ///< three numbers, two for a planar base
  std::optional<Quaternion<double>> orientation;  ///< floating
  std::optional<double> yaw;                      ///< planar, rad
};

/// A motion of a base in the horizontal plane: forward and to the left as it points before (m),
/// and a turn about its origin (rad).
struct PlanarMotion {
  double x = 0, y = 0, yaw = 0;
};

/// How far a base is displaced: by a motion, or as the file's gait moves it.
struct DisplacementSpec {
  Place place;
  bool with_gait = false;
  PlanarMotion motion;
};

struct NamedState;

/// A state, in one of the ways in which a file can say it. What is not mentioned is neutral: zero,
/// no rotation, at rest.
struct StateSpec {
  Place place;
  std::optional<Name> configuration;
  std::optional<BaseSpec> base;
  std::optional<DisplacementSpec> displaced;  ///< of the base that the keys before have placed
  NamedNumbers joints;
  std::optional<TwistSpec> base_velocity;
  NamedNumbers joint_velocities;
  /// Several robots: the state of each, by its name.
  std::vector<NamedState> robots;
  /// All numbers of the state.
  std::optional<std::vector<double>> state;
  /// By column name.
  NamedNumbers values;
  /// Of problems that use the control rate.
  std::optional<ComponentsSpec> previous_control;
};

struct NamedState {
  Name name;
  StateSpec state;
};

}  // namespace conddp
