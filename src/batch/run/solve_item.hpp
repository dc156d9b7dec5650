#pragma once

#include <string>

#include "batch/plan/manifest.hpp"
#include "batch/results/result.hpp"

namespace conddp {

/// A result, and the whole solution.json on one line with its end where it is kept.
struct SolvedItem {
  ItemResult result;
  std::string solution;
};

/// Builds, solves and certifies one item, with one thread.
SolvedItem solve_item(const ManifestItem& item, const ManifestProblem& problem,
                      const ProblemFamily& family, KeptSolutions keep);

}  // namespace conddp
