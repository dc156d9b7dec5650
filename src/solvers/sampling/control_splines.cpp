#include "solvers/sampling/control_splines.hpp"

namespace conddp {

ControlSplines::ControlSplines(const ShootingProblem& problem, const Trajectory& nominal)
    : problem_(problem), nominal_(nominal), entries_(problem.knots()) {}

int ControlSplines::add_channel(int nodes, double scale) {
  const int first = parameters();
  scales_.insert(scales_.end(), nodes, scale);
  return first;
}

void ControlSplines::add_entry(int knot, int control, int channel,
                               std::span<const double> weights) {
  entries_[knot].push_back(
      {control, channel, static_cast<int>(weights_.size()), static_cast<int>(weights.size())});
  weights_.insert(weights_.end(), weights.begin(), weights.end());
}

}  // namespace conddp
