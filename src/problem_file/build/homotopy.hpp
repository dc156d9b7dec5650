#pragma once

#include <memory>
#include <optional>

#include "problem_file/build/build.hpp"

namespace conddp {

/// The problems along the homotopy of a file.
class Homotopy {
 public:
  /// An intermediate problem and its file at that share, both without guess and homotopy.
  struct Station {
    ProblemSpec spec;
    std::optional<BuiltProblem> built;
  };

  /// Null, with errors at the homotopy's keys, if the first problem cannot be built or an
  /// intermediate problem differs in shape from the one at the end.
  static std::shared_ptr<const Homotopy> build(const ProblemSpec& spec, const BuildOptions& options,
                                               const ShootingProblem& end, Diagnostics& out);

  const Station& start() const { return *start_; }
  /// Problems as a function of the share; null if a problem cannot be built. May outlive the
  /// homotopy object.
  static ProblemPath path(std::shared_ptr<const Homotopy> homotopy);

 private:
  std::shared_ptr<const Station> station(double share, Diagnostics& out) const;

  std::string text_;
  std::filesystem::path file_;
  std::vector<std::string> settings_;
  SolverSpec solver_;
  Perturbation perturbation_;
  BuildOptions options_;
  std::shared_ptr<const Station> start_;
};

/// Homotopy that the file of a built problem requests, or null.
ProblemPath homotopy_path(const BuiltProblem& built);

}  // namespace conddp
