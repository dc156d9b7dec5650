#include "problem_file/model/phase_grid.hpp"

#include <cmath>
#include <numeric>

namespace conddp {

std::vector<double> relative_steps(const PhaseSpec& phase) {
  const int n = phase.knots.value;
  std::vector<double> steps(n, 1.0);
  if (!phase.refine) return steps;
  const RefineSpec& refine = *phase.refine;
  for (int i = 0; i < refine.first; ++i) steps[i] = std::pow(refine.ratio, refine.first - i);
  for (int i = 0; i < refine.last; ++i) steps[n - 1 - i] = std::pow(refine.ratio, refine.last - i);
  return steps;
}

std::vector<double> phase_steps(const PhaseSpec& phase) {
  std::vector<double> steps = relative_steps(phase);
  for (double& step : steps) step *= phase.dt;
  return steps;
}

double phase_duration(const PhaseSpec& phase) {
  const std::vector<double> steps = relative_steps(phase);
  return phase.dt * std::accumulate(steps.begin(), steps.end(), 0.0);
}

}  // namespace conddp
