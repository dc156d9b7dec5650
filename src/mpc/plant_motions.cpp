#include "mpc/plant_motions.hpp"

#include <stdexcept>
#include <utility>

namespace conddp {

const PlantPeriod* period_at(std::span<const PlantPeriod> periods, double time) {
  const PlantPeriod* current = nullptr;
  for (const PlantPeriod& period : periods)
    if (current == nullptr || !is_before(time, period.from)) current = &period;
  return current;
}

PlantMotions::PlantMotions(std::span<const PlantPeriod> periods, const StepRule& step,
                           const TimeLine& model) {
  if (periods.empty()) add(0, std::make_shared<Simulation>(model, step));
  for (const PlantPeriod& period : periods) {
    if (period.motion != nullptr) {
      add(period.from, period.motion);
      continue;
    }
    const ShootingProblem& problem = *period.problem;
    if (problem.times() != model.problem().times() || problem.nx() != model.problem().nx())
      throw std::invalid_argument("the plant has other states or times than the model");
    lines_.push_back(std::make_unique<TimeLine>(period.problem, model.is_held()));
    add(period.from, std::make_shared<Simulation>(*lines_.back(), step));
  }
  if (begins_.front() > 0) throw std::invalid_argument("the plant's first period begins at time 0");
}

PlantMotion& PlantMotions::at(double time) const {
  std::size_t current = 0;
  for (std::size_t i = 1; i < begins_.size(); ++i)
    if (!is_before(time, begins_[i])) current = i;
  return *motions_[current];
}

void PlantMotions::add(double from, std::shared_ptr<PlantMotion> motion) {
  begins_.push_back(from);
  motions_.push_back(std::move(motion));
}

}  // namespace conddp
