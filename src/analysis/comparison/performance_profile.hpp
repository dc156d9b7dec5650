#pragma once

#include <string>
#include <utility>
#include <vector>

namespace conddp {

/// The share of a set of problems that a solver solves within τ: so many times what the best solver
/// needs (a performance profile; Dolan, Moré 2002), or so much effort (a data profile; Moré, Wild
/// 2009).
struct PerformanceProfile {
  std::string solver;
  /// (τ, share) where the share rises, τ increasing; empty where it solves nothing.
  std::vector<std::pair<double, double>> steps;

  /// The share at τ.
  double share(double tau) const;
};

/// `effort[p][s]`: what solver s needed for problem p (time, iterations), infinite where it did not
/// solve it. Where the best effort is 0 the solvers with 0 have the ratio 1 and all others have 1
/// plus their effort.
std::vector<PerformanceProfile> performance_profiles(
    const std::vector<std::string>& solvers, const std::vector<std::vector<double>>& effort);

/// The same effort, compared with nothing: a unit that no machine and no other solver changes, as
/// backward sweeps, makes profiles that can be laid beside those of another run.
std::vector<PerformanceProfile> data_profiles(const std::vector<std::string>& solvers,
                                              const std::vector<std::vector<double>>& effort);

}  // namespace conddp
