#pragma once

#include <memory>
#include <string>
#include <vector>

#include "ocp/terms/residual.hpp"
#include "systems/multibody/multibody.hpp"

namespace conddp {

/// A residual of the configuration whose rows are to lie between two bounds.
struct PostureGoal {
  std::shared_ptr<const Residual> residual;
  std::vector<double> parameters;
  double lower = 0, upper = 0;
};

/// A state, and by how much it misses each contact that the system holds, then each goal: norms of
/// rows outside their bounds, m, with angles times 1 m.
struct Posture {
  std::vector<double> x;
  std::vector<double> gaps;

  /// Gap below which a goal is met.
  static constexpr double kMet = 1e-7;
  bool found() const;
};

/// Inverse kinematics. Moves the given joints, each with one velocity index, within their limits to
/// meet all goals and close the contacts that the system holds. The motion from the state x is
/// small (sum of squares). If the way from x ends with a gap, random positions start 19 other ways.
/// The result is the one with the least motion among those without a gap, otherwise that with the
/// smallest gap. Steps are Levenberg-Marquardt's on a penalty of the motion that tends to zero;
/// joints at a limit that they press on keep it. The same for the same input.
Posture find_posture(const MultibodySystem& system, const std::vector<PostureGoal>& goals,
                     const std::vector<int>& joints, const std::vector<double>& x);

/// The gaps of a posture as it is.
std::vector<double> posture_gaps(const MultibodySystem& system,
                                 const std::vector<PostureGoal>& goals,
                                 const std::vector<double>& x);

/// The revolute and prismatic joints with their own coordinate, among `count` from `first` on.
std::vector<int> movable_joints(const MultibodySystem& system, int first, int count);

/// Positions of these joints that differ from another state's: "{knee: 0.8123}". Empty for equal
/// states.
std::string changed_joints(const MultibodySystem& system, const std::vector<double>& from,
                           const std::vector<double>& to);

}  // namespace conddp
