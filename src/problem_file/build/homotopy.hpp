#pragma once

#include <memory>
#include <optional>

#include "problem_file/build/build.hpp"

namespace conddp {

/// The problems on the way of a file's homotopy.
class Homotopy {
 public:
  /// A problem of the way with the file as it stands there. Neither has a guess or a homotopy.
  struct Station {
    ProblemSpec spec;
    std::optional<BuiltProblem> built;
  };

  /// Null with errors, which have their places in the list of its keys, where the way cannot begin,
  /// or leads through problems of another shape than the one at its end.
  static std::shared_ptr<const Homotopy> build(const ProblemSpec& spec, const BuildOptions& options,
                                               const ShootingProblem& end, Diagnostics& out);

  const Station& start() const { return *start_; }
  /// The problems by their share of the way; null where one cannot be built. It may outlive this
  /// object.
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

/// The way to a built problem that its file asks for; null: none.
ProblemPath homotopy_path(const BuiltProblem& built);

}  // namespace conddp
