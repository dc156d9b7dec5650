#pragma once

#include <memory>
#include <optional>
#include <vector>

#include "mpc/open_end.hpp"
#include "problem_file/assemble/build.hpp"
#include "problem_file/terms/terminal_lqr.hpp"

namespace conddp {

/// The regulator of a closed loop about a state of its file. It moves along the path of the file's
/// gait, if any.
struct LoopRegulator {
  Phase end;                        ///< a last node with only its cost-to-go
  TerminalIngredients ingredients;  ///< at the end of the path
  std::vector<double> start;        ///< state at the start of the path; empty if it stays
};

/// Builds the regulator and reports its errors. A planar base cannot follow a gait that turns: the
/// axes of the base are those of its plane, so the cost-to-go does not turn with it.
std::optional<LoopRegulator> build_loop_regulator(const TerminalLqrSpec& lqr,
                                                  const ProblemSpec& spec,
                                                  const BuiltProblem& built, Diagnostics& out);

/// Path of a state along `way`, at the times of a problem's nodes; null if `start` is empty.
std::shared_ptr<const StatePath> path_along(const std::vector<WayPoint>& way,
                                            const std::vector<double>& times,
                                            const std::vector<double>& start, const Plant& plant);

}  // namespace conddp
