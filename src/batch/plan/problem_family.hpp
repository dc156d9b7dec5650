#pragma once

#include <filesystem>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "output/mpc/loop_task.hpp"
#include "problem_file/assemble/build_problem.hpp"

namespace conddp {

/// Describes the number layout of a problem's trajectories and multipliers, as text. Problems with
/// the same shape have the same layout.
std::string shape_of(const ShootingProblem& problem);

/// All problems that result from one file with different settings. The file is parsed once, and its
/// robots are loaded once for all settings that do not change them. Thread-safe.
class ProblemFamily {
 public:
  /// Reads and builds the file's own problem. Null, with errors, on failure; an unreadable file is
  /// reported at `place`.
  static std::shared_ptr<const ProblemFamily> load(const std::filesystem::path& file,
                                                   const Place& place, Diagnostics& out);
  /// The same from a text. Relative paths are resolved against the folder of `file`, which need not
  /// exist.
  static std::shared_ptr<const ProblemFamily> parse(std::string text,
                                                    const std::filesystem::path& file,
                                                    Diagnostics& out);

  const ProblemDocument& document() const { return document_; }
  /// The texts that places in the file refer to.
  const Diagnostics& texts() const { return texts_; }
  /// The file's own problem.
  const BuiltProblem& base() const { return base_; }
  /// The problem with settings. Null, with errors in `out`, on failure; `out` must know the texts
  /// of the family and of the settings. The family must outlive the result. `start`: a solution
  /// file whose states, controls and multipliers replace the file's own guess.
  std::optional<BuiltProblem> build(
      const std::vector<Setting>& settings, Diagnostics& out,
      const std::optional<Located<std::filesystem::path>>& start = {}) const;
  /// Same as above, for the closed loop.
  std::unique_ptr<LoopTask> build_loop(const std::vector<Setting>& settings,
                                       Diagnostics& out) const;

 private:
  static std::shared_ptr<const ProblemFamily> of(std::optional<ProblemDocument> document,
                                                 Diagnostics& out);
  /// The base's plant if these settings do not change it, else null.
  const Plant* plant_with(const std::vector<Setting>& settings) const;

  Diagnostics texts_;
  ProblemDocument document_;
  BuiltProblem base_;
  std::optional<Plant> plant_;  ///< of the base, if instances may share it
};

}  // namespace conddp
