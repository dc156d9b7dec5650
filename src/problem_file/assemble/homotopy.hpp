#pragma once

#include <memory>
#include <optional>

#include "problem_file/assemble/build.hpp"

namespace conddp {

/// The problems along the homotopy of a file.
class Homotopy {
 public:
  /// Null, with errors at the homotopy's keys, if the first problem cannot be built or an
  /// intermediate problem differs in shape from the one at the end.
  static std::shared_ptr<const Homotopy> build(const BuiltProblem& end, const BuildOptions& options,
                                               Diagnostics& out);

  /// The first problem, without guess and homotopy.
  const BuiltProblem& start() const { return *start_; }
  /// Problems as a function of the share; null if a problem cannot be built. May outlive the
  /// homotopy object.
  static ProblemPath path(std::shared_ptr<const Homotopy> homotopy);

 private:
  /// The problem at a share of the way, without guess and homotopy.
  std::shared_ptr<const BuiltProblem> station(double share, Diagnostics& out) const;

  std::shared_ptr<const ProblemSpec> end_;
  BuildOptions options_;
  std::shared_ptr<const BuiltProblem> start_;
};

/// Homotopy that the file of a built problem requests, or null.
ProblemPath homotopy_path(const BuiltProblem& built);

}  // namespace conddp
