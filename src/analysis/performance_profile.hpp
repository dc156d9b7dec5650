#pragma once

#include <string>
#include <utility>
#include <vector>

namespace conddp {

/// How a solver compares with the best of all over a set of problems (Dolan, Moré 2002): the share
/// of problems that it solves within τ times what the best solver needs.
struct PerformanceProfile {
  std::string solver;
  /// (τ, share) where the share rises, τ increasing from 1 on; empty where it solves nothing.
  std::vector<std::pair<double, double>> steps;

  /// The share at τ.
  double share(double tau) const;
};

/// `effort[p][s]`: what solver s needed for problem p (time, iterations), infinite where it did not
/// solve it. Where the best effort is 0 the solvers with 0 have the ratio 1 and all others have 1
/// plus their effort.
std::vector<PerformanceProfile> performance_profiles(
    const std::vector<std::string>& solvers, const std::vector<std::vector<double>>& effort);

}  // namespace conddp
