#pragma once

#include <array>
#include <filesystem>

#include "ocp/residuals/residuals.hpp"
#include "ocp/terms/activation.hpp"
#include "problem_file/spec/residual_kind.hpp"
#include "problem_file/spec/spec_values.hpp"

namespace conddp {

/// One value of a reference, in the form that fits its residual.
struct ReferenceValueSpec {
  Place place;
  std::optional<Name> name;  ///< a configuration, or "initial"
  std::optional<ComponentsSpec> components;
  std::optional<StateSpec> state;
  std::optional<PoseSpec> pose;
  std::optional<TwistSpec> twist;
};

/// Columns of a CSV file or of a former solution, over time.
struct DataFileSpec {
  Name file;
  std::filesystem::path path;  ///< resolved against the problem file's folder
  std::vector<Name> columns;   ///< empty: those of the quantity itself
};

/// One value; way-points between which knots interpolate; or a file.
struct ReferenceSpec {
  Place place;
  std::vector<ReferenceValueSpec> values;
  std::vector<Located<double>> times;  ///< of way-points, s
  std::vector<Located<int>> knots;     ///< of way-points
  std::optional<DataFileSpec> file;
};

struct ActivationSpec {
  Place place;
  ActivationKind kind = ActivationKind::quadratic;
  std::optional<ComponentsSpec> lower, upper;  ///< of the barrier
  bool from_urdf = false;                      ///< the barrier's bounds are the robot's limits
  double epsilon = 0.1;                        ///< of the smooth norms
};

/// Which approximation of a friction cone, and how much of the friction to use.
struct FrictionConeSpec {
  bool second_order = false;
  int faces = 4;
  bool inner = true;
  double safety = 1;  ///< factor on the coefficient of friction, at most 1
};

/// A foot's way from lift-off to touch-down: an arch of this height over the straight line.
struct SwingSpec {
  Place place;
  double height = 0;                       ///< m
  std::optional<Vector3<double>> landing;  ///< where it touches down, m
  std::optional<Vector3<double>> step;     ///< the same from where it lifts off, m
  /// The same, one a run of phases: where the frame was in the initial state, displaced with the
  /// robot's base.
  std::vector<PlanarMotion> displaced;
};

/// Which shapes must keep apart.
struct PairsSpec {
  enum class Choice { kNamed, kObstacles, kSelf, kAll };
  Place place;
  Choice choice = Choice::kNamed;
  std::vector<std::array<Name, 2>> named;  ///< names may have a `*`
};

struct CostSpec {
  Name name;
  Name residual;
  ResidualKind kind = ResidualKind::kState;
  double weight = 1;
  ActivationSpec activation;
  std::optional<ComponentsSpec> weights;  ///< of the components, besides `weight`
  std::optional<ReferenceSpec> reference;
  std::optional<Name> frame;
  std::optional<std::vector<Name>> joints;
  std::optional<std::vector<Name>> columns;
  FrameAxes axes = FrameAxes::world_aligned;
  ContactNames contacts{.all = true};
  FrictionConeSpec cone;
  std::optional<SwingSpec> swing;
  std::optional<ComponentsSpec> offset;  ///< of a cycle, to the first state's columns
  /// Of combinations: the factors of a row by column; `constant` is added.
  std::vector<NamedNumbers> combinations;
  PairsSpec pairs;
  /// Of distances without an activation: the lower end of their barrier, m.
  std::optional<double> margin;
  std::optional<std::vector<Name>> phases;
  std::optional<std::vector<Located<int>>> knots;
};

/// Quantities on which a constraint can put bounds.
enum class BoundedQuantity { kControl, kState, kConfiguration, kVelocity };

/// A constraint other than bounds on the control: a residual in a set, or bounds on coordinates of
/// the state. Without equals, bounds or a cone the residual is zero.
struct ConstraintSpec {
  CostSpec function;  ///< the residual and where it holds; of its cone `second_order` counts
  std::optional<Located<BoundedQuantity>> bounded;  ///< instead of the residual
  bool from_urdf = false;
  Place from_place;
  double scale = 1;  ///< of the URDF's limits
  std::optional<ComponentsSpec> equals, lower, upper;
  /// References for each of which the constraint holds, instead of one.
  std::vector<Located<std::vector<double>>> centers;
  std::optional<double> at_least, at_most;  ///< of the residual's norm
  double slope = 1;                         ///< of a cone
  Softness softness = Softness::hard;
  double weight = 1;  ///< of a soft one
};

/// Bounds on the control.
struct ControlBoundsSpec {
  Name name;
  bool from_urdf = false;
  Place from_place;
  double scale = 1;  ///< of the URDF's limits
  std::optional<ComponentsSpec> lower, upper;
  std::optional<std::vector<Name>> phases;
};

}  // namespace conddp
