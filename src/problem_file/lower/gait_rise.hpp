#pragma once

#include "problem_file/model/spec.hpp"

namespace conddp {

/// Landings of a foot of a gait: shares of the base's path, and motions since the start.
struct PathOfFoot {
  Name frame;
  std::vector<double> shares;
  std::vector<PlanarMotion> motions;
};

/// Rise of a gait's base over a terrain. A foothold is half-way through its stance where the base
/// has covered the share of its landing. There the height of the foot is that of the foothold, and
/// between footholds it is interpolated linearly; the base rises by the mean over all feet.
class GaitRise {
 public:
  GaitRise() = default;
  /// Loads the robots of the problem, whose errors are reported when it is built. Feet without
  /// ground do not rise.
  GaitRise(const std::vector<PathOfFoot>& feet, const ProblemSpec& spec);

  /// Rise since the start at a share of the path, m.
  double at(double share) const;
  /// Shares where the rate of the rise changes.
  std::vector<double> bends() const;

 private:
  struct Heights {
    std::vector<double> shares, rises;
  };
  std::vector<Heights> feet_;
};

}  // namespace conddp
