#include "analysis/performance_profile.hpp"

#include <algorithm>
#include <cmath>

namespace conddp {

double PerformanceProfile::share(double tau) const {
  double value = 0;
  for (const auto& [ratio, share] : steps)
    if (ratio <= tau) value = share;
  return value;
}

std::vector<PerformanceProfile> performance_profiles(
    const std::vector<std::string>& solvers, const std::vector<std::vector<double>>& effort) {
  std::vector<PerformanceProfile> profiles;
  for (std::size_t s = 0; s < solvers.size(); ++s) {
    std::vector<double> ratios;
    for (const std::vector<double>& of_problem : effort) {
      const double best = *std::min_element(of_problem.begin(), of_problem.end());
      if (!std::isfinite(of_problem[s])) continue;
      ratios.push_back(best > 0 ? of_problem[s] / best : 1 + of_problem[s]);
    }
    std::sort(ratios.begin(), ratios.end());
    PerformanceProfile profile{.solver = solvers[s], .steps = {}};
    for (std::size_t i = 0; i < ratios.size(); ++i) {
      if (i + 1 < ratios.size() && ratios[i + 1] == ratios[i]) continue;
      profile.steps.emplace_back(ratios[i],
                                 static_cast<double>(i + 1) / static_cast<double>(effort.size()));
    }
    profiles.push_back(std::move(profile));
  }
  return profiles;
}

}  // namespace conddp
