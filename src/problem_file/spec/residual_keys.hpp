#pragma once

#include <array>
#include <optional>

#include "problem_file/spec/key_values.hpp"
#include "problem_file/spec/spec_values.hpp"

namespace conddp {

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

/// Keys of residuals that more than their definitions read.
namespace key {

inline const Key<Name> frame{"frame"};
inline const Key<std::vector<Name>> columns{"columns"};
inline const Key<ContactNames> contacts{"contacts", {.all = true}};
/// Whether a cone is of second order.
inline const Key<bool> cone{"cone", false};
/// Factor on the coefficient of friction, at most 1.
inline const Key<double> safety{"safety", 1};
inline const Key<SwingSpec> swing{"swing"};
inline const Key<PairsSpec> pairs{"pairs"};
/// Of distances without an activation: the lower end of their barrier, m.
inline const Key<double> margin{"margin", 0};

}  // namespace key

}  // namespace conddp
