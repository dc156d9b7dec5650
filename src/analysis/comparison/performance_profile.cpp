#include "analysis/comparison/performance_profile.hpp"

#include <algorithm>
#include <cmath>

namespace conddp {

double PerformanceProfile::share(double tau) const {
  double value = 0;
  for (const auto& [ratio, share] : steps)
    if (ratio <= tau) value = share;
  return value;
}

namespace {

/// For each number, the share of `problems` with a number that is not larger.
std::vector<std::pair<double, double>> share_steps(std::vector<double> numbers,
                                                   std::size_t problems) {
  std::sort(numbers.begin(), numbers.end());
  std::vector<std::pair<double, double>> steps;
  for (std::size_t i = 0; i < numbers.size(); ++i) {
    if (i + 1 < numbers.size() && numbers[i + 1] == numbers[i]) continue;
    steps.emplace_back(numbers[i], static_cast<double>(i + 1) / static_cast<double>(problems));
  }
  return steps;
}

}  // namespace

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
    profiles.push_back(
        {.solver = solvers[s], .steps = share_steps(std::move(ratios), effort.size())});
  }
  return profiles;
}

std::vector<PerformanceProfile> data_profiles(const std::vector<std::string>& solvers,
                                              const std::vector<std::vector<double>>& effort) {
  std::vector<PerformanceProfile> profiles;
  for (std::size_t s = 0; s < solvers.size(); ++s) {
    std::vector<double> needed;
    for (const std::vector<double>& of_problem : effort)
      if (std::isfinite(of_problem[s])) needed.push_back(of_problem[s]);
    profiles.push_back(
        {.solver = solvers[s], .steps = share_steps(std::move(needed), effort.size())});
  }
  return profiles;
}

}  // namespace conddp
