#pragma once

#include <memory>
#include <optional>
#include <vector>

#include "mpc/state_path.hpp"
#include "problem_file/build/build.hpp"
#include "problem_file/terms/terminal_lqr.hpp"

namespace conddp {

/// The regulator of a closed loop about a state of its file, which moves along the way of the
/// file's gait if there is one.
struct LoopRegulator {
  Phase end;                        ///< a last node with its cost-to-go alone
  TerminalIngredients ingredients;  ///< where the way ends
  std::vector<double> start;        ///< its state where the way begins; empty: it stays
};

/// Builds it. What is wrong with it is reported, also where it cannot follow the gait: the axes of
/// a planar base are those of its plane, in which the cost-to-go does not turn.
std::optional<LoopRegulator> build_loop_regulator(const TerminalLqrSpec& lqr,
                                                  const ProblemSpec& spec,
                                                  const BuiltProblem& built, Diagnostics& out);

/// The path of a state along a way with the times of a problem's nodes; null where there is no
/// state.
std::shared_ptr<const StatePath> path_along(const std::vector<WayPoint>& way,
                                            const std::vector<double>& times,
                                            const std::vector<double>& start, const Plant& plant);

}  // namespace conddp
