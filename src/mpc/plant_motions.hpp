#pragma once

#include <memory>
#include <span>
#include <vector>

#include "mpc/simulation.hpp"

namespace conddp {

/// From a time on the plant moves as this problem's systems do, phase by phase, or in a way of its
/// own. Its actuators give no more than the problem's bounds on the control allow.
struct PlantPeriod {
  double from = 0;  ///< s
  std::shared_ptr<const ShootingProblem> problem = nullptr;
  std::shared_ptr<PlantMotion> motion = nullptr;  ///< in place of the problem's systems
};

/// The period in which a time lies, of periods in order; null: there are none.
const PlantPeriod* period_at(std::span<const PlantPeriod> periods, double time);

/// How a plant moves, period by period.
class PlantMotions {
 public:
  /// `periods` from time 0 on, in order; none: the plant moves as the model does, which has to live
  /// longer than this. Throws std::invalid_argument where a period has other states or times than
  /// the model, or the first one begins later.
  PlantMotions(std::span<const PlantPeriod> periods, const StepRule& step, const TimeLine& model);

  PlantMotion& at(double time) const;
  /// When periods begin, s.
  const std::vector<double>& begins() const { return begins_; }

 private:
  void add(double from, std::shared_ptr<PlantMotion> motion);

  std::vector<std::unique_ptr<TimeLine>> lines_;
  std::vector<double> begins_;
  std::vector<std::shared_ptr<PlantMotion>> motions_;
};

}  // namespace conddp
