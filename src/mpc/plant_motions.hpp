#pragma once

#include <memory>
#include <span>
#include <vector>

#include "mpc/simulation.hpp"

namespace conddp {

/// From a time on, the plant moves as this problem's systems do, phase by phase, or by its own
/// motion. Its actuators are limited by the problem's control bounds.
struct PlantPeriod {
  double from = 0;  ///< s
  std::shared_ptr<const ShootingProblem> problem = nullptr;
  std::shared_ptr<PlantMotion> motion = nullptr;  ///< replaces the problem's systems
};

/// Period that contains a time, from periods in order; null for an empty list.
const PlantPeriod* period_at(std::span<const PlantPeriod> periods, double time);

/// Motions of a plant, period by period.
class PlantMotions {
 public:
  /// `periods` begin at time 0, in order. If empty, the plant moves as the model, which must
  /// outlive this. Throws std::invalid_argument if a period's states or times differ from the
  /// model's, or the first period begins after time 0.
  PlantMotions(std::span<const PlantPeriod> periods, const StepRule& step, const TimeLine& model);

  PlantMotion& at(double time) const;
  /// Start times of the periods, s.
  const std::vector<double>& begins() const { return begins_; }

 private:
  void add(double from, std::shared_ptr<PlantMotion> motion);

  std::vector<std::unique_ptr<TimeLine>> lines_;
  std::vector<double> begins_;
  std::vector<std::shared_ptr<PlantMotion>> motions_;
};

}  // namespace conddp
