#pragma once

#include <filesystem>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "output/mpc/loop_task.hpp"
#include "problem_file/read/read_problem.hpp"

namespace conddp {

/// A problem with settings of its own.
struct ProblemInstance {
  std::unique_ptr<const ProblemSpec> spec;
  BuiltProblem built;
};

/// What problems have in common whose trajectories and multipliers have the same numbers, as text.
std::string shape_of(const ShootingProblem& problem);

/// The problems that one file stands for with different settings. The file is parsed once, and its
/// robots are loaded once for all settings that leave them as they are. Threads may share it.
class ProblemFamily {
 public:
  /// Reads and builds the file's own problem. Null with errors; a file that cannot be read is
  /// reported at `place`.
  static std::shared_ptr<const ProblemFamily> load(const std::filesystem::path& file,
                                                   const Place& place, Diagnostics& out);

  /// The file.
  const ProblemDocument& document() const { return document_; }
  /// The texts to which places in the file lead.
  const Diagnostics& texts() const { return texts_; }
  /// The file's own problem.
  const ProblemInstance& base() const { return base_; }
  /// The problem with settings. Null with errors in `out`, which must know the texts of the family
  /// and of the settings. It lives no longer than the family. `start`: the file of a solution whose
  /// states, controls and multipliers are the guess, instead of what the file says about it.
  std::optional<ProblemInstance> build(const std::vector<Setting>& settings, Diagnostics& out,
                                       const Located<std::filesystem::path>* start = nullptr) const;
  /// The same of the closed loop.
  std::unique_ptr<LoopTask> build_loop(const std::vector<Setting>& settings,
                                       Diagnostics& out) const;

 private:
  /// What moves, where that is the base's; else null.
  const Plant* plant_with(const std::vector<Setting>& settings) const;

  Diagnostics texts_;
  ProblemDocument document_;
  ProblemInstance base_;
  std::optional<Plant> plant_;  ///< of the base, as far as instances may share it
};

}  // namespace conddp
