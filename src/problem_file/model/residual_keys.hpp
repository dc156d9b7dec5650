#pragma once

#include <array>
#include <optional>

#include "problem_file/model/key_values.hpp"
#include "problem_file/model/spec_expression.hpp"
#include "problem_file/model/spec_values.hpp"

namespace conddp {

/// Path of a foot from lift-off to touch-down: an arch of this height over the straight line.
struct SwingSpec {
  Place place;
  double height = 0;                       ///< m
  std::optional<Vector3<double>> landing;  ///< touch-down position, m
  std::optional<Vector3<double>> step;     ///< touch-down relative to lift-off, m
  /// One motion for each run of consecutive phases: the frame's initial position moves with the
  /// robot's base.
  std::vector<PlanarMotion> displaced;
};

/// Shape pairs to keep apart.
struct PairsSpec {
  enum class Choice { kNamed, kObstacles, kSelf, kAll };
  Place place;
  Choice choice = Choice::kNamed;
  std::vector<std::array<Name, 2>> named;  ///< names may have a `*`
};

/// Residual keys that are read outside their definitions.
namespace key {

inline const Key<Name> frame{"frame"};
inline const Key<std::vector<Name>> columns{"columns"};
inline const Key<ContactNames> contacts{"contacts", ContactNames{.all = true}};
/// True for a second-order cone.
inline const Key<bool> cone{"cone", false};
/// Factor on the coefficient of friction, at most 1.
inline const Key<double> safety{"safety", 1};
inline const Key<SwingSpec> swing{"swing"};
/// The factors of a row by column; `constant` is added.
inline const Key<std::vector<NamedNumbers>> combination_rows{"rows"};
inline const Key<ExpressionRowsSpec> expression_rows{"rows"};
inline const Key<PairsSpec> pairs{"pairs"};
/// Distances without an activation: lower bound of their barrier, m; 0 without the key.
inline const Key<double> margin{"margin"};

}  // namespace key

}  // namespace conddp
