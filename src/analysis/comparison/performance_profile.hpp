#pragma once

#include <string>
#include <utility>
#include <vector>

namespace conddp {

/// Share of a set of problems that a solver solves within τ. For a performance profile, τ is a
/// multiple of the best solver's effort (Dolan, Moré 2002); for a data profile, it is an effort
/// (Moré, Wild 2009).
struct PerformanceProfile {
  std::string solver;
  /// (τ, share) at each rise of the share, in ascending order of τ; empty if no problem is solved.
  std::vector<std::pair<double, double>> steps;

  /// Share at τ.
  double share(double tau) const;
};

/// `effort[p][s]`: effort of solver s for problem p (time, iterations), infinite if it did not
/// solve it. If the best effort is 0, solvers with 0 have the ratio 1 and all others have 1 plus
/// their effort.
std::vector<PerformanceProfile> performance_profiles(
    const std::vector<std::string>& solvers, const std::vector<std::vector<double>>& effort);

/// The same for the effort itself, without comparison. A unit that is independent of the machine
/// and other solvers, such as backward sweeps, makes profiles of different runs comparable.
std::vector<PerformanceProfile> data_profiles(const std::vector<std::string>& solvers,
                                              const std::vector<std::vector<double>>& effort);

}  // namespace conddp
