#pragma once

#include <filesystem>

#include "ocp/terms/activation.hpp"
#include "ocp/terms/constraint.hpp"
#include "problem_file/model/residual_keys.hpp"
#include "problem_file/model/spec_values.hpp"

namespace conddp {

struct ResidualDefinition;

/// One reference value, in the form of its residual.
struct ReferenceValueSpec {
  Place place;
  std::optional<Name> name;  ///< a configuration, or "initial"
  std::optional<ComponentsSpec> components;
  std::optional<StateSpec> state;
  std::optional<PoseSpec> pose;
  std::optional<TwistSpec> twist;
};

/// Columns of a CSV file or of a former solution over time.
struct DataFileSpec {
  Name file;
  std::filesystem::path path;  ///< resolved against the problem file's folder
  std::vector<Name> columns;   ///< empty: the quantity's own columns
};

/// A single value, way-points to interpolate between, or a file.
struct ReferenceSpec {
  Place place;
  std::vector<ReferenceValueSpec> values;
  std::vector<Located<double>> times;  ///< of way-points, s
  std::vector<KnotSpec> knots;         ///< of way-points
  std::optional<DataFileSpec> file;
};

struct ActivationSpec {
  Place place;
  ActivationKind kind = ActivationKind::quadratic;
  std::optional<ComponentsSpec> lower, upper;  ///< of the barrier
  bool from_urdf = false;                      ///< the barrier's bounds are the robot's limits
  double epsilon = 0.1;                        ///< of the smooth norms
};

/// Place of a residual: in a cost, a constraint, an integral, an expression or a drawing, on
/// running knots or at the last node.
struct TermPlace {
  enum class Kind { kCost, kConstraint, kIntegral, kOperand, kDrawing };
  Kind kind = Kind::kCost;
  bool last_node = false;
};

struct CostSpec {
  Name name;
  TermPlace where;
  Name residual;
  const ResidualDefinition* definition = nullptr;
  KeyValues keys;                       ///< of the residual
  bool names_previous_control = false;  ///< in its expressions
  double weight = 1;
  ActivationSpec activation;
  std::optional<ComponentsSpec> weights;  ///< component weights, multiplied by `weight`
  std::optional<MatrixSpec> matrix;       ///< replaces component weights
  std::optional<ReferenceSpec> reference;
  std::optional<std::vector<Name>> phases;
  std::optional<std::vector<KnotSpec>> knots;
  /// Constraints: true if it also applies to the nodes at the end of its phases.
  Located<bool> ends{false, {}};
};

/// Quantities that a constraint can bound.
enum class BoundedQuantity { kControl, kState, kConfiguration, kVelocity };

/// A constraint: a residual in a set, or bounds on the control or on coordinates of the state.
/// Without equals, bounds or a cone the residual is zero.
struct ConstraintSpec {
  CostSpec function;  ///< the residual and where it holds; its key `cone` applies
  std::optional<Located<BoundedQuantity>> bounded;  ///< replaces the residual
  std::optional<Place> from_urdf;                   ///< place of `from: urdf`
  double scale = 1;                                 ///< of the URDF's limits
  std::optional<ComponentsSpec> equals, lower, upper;
  /// Several references, which replace the single one; the constraint holds for each.
  std::vector<Located<std::vector<double>>> centers;
  std::optional<double> at_least, at_most;  ///< of the residual's norm
  double slope = 1;                         ///< of a cone
  Softness softness = Softness::hard;
  double weight = 1;  ///< of a soft one

  /// True for hard bounds on the control, which solvers satisfy at every iterate.
  bool bounds_controls() const {
    return bounded && bounded->value == BoundedQuantity::kControl && softness == Softness::hard;
  }
};

}  // namespace conddp
