#pragma once

#include <vector>

#include "problem_file/model/spec.hpp"

namespace conddp {

/// The time of a node: numbers, and how it depends on the free durations.
struct NodeTime {
  double written = 0;  ///< t, s, with the durations of the file
  /// t, the time since the beginning of the phase that contains the node or begins there (at the
  /// last node: the last phase), and the time of the last node, s. Free durations are not included.
  double time = 0, phase_time = 0, final_time = 0;
  /// Coefficients of each free duration in t and in the phase time. In the final time each
  /// coefficient is 1.
  std::vector<double> share, phase_share;

  /// Appends the parameters of expressions (ExpressionResidualText): t, phase time, final time and
  /// the coefficients of the free durations.
  void append_to(std::vector<double>& parameters) const;
};

/// The time inside a knot's interval after the fraction `passed` of its step (s), in phase `phase`
/// of a problem.
NodeTime time_within(const NodeTime& knot, double step, double passed, const ProblemSpec& spec,
                     std::size_t phase);

/// Times of all nodes. `written`: node times with the durations of the file, s. `start`: initial
/// value of a clock in the state, s; t starts there.
std::vector<NodeTime> node_times(const ProblemSpec& spec, const std::vector<double>& written,
                                 double start = 0);

}  // namespace conddp
