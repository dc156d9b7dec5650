#pragma once

#include <vector>

#include "problem_file/spec/spec.hpp"

namespace conddp {

/// The time of a node: numbers, and how it grows with the free durations.
struct NodeTime {
  double written = 0;  ///< t, s, with the durations of the file
  /// t, the time since the beginning of the phase that begins at the node or has it inside (at the
  /// last node: of the last phase), and the time of the last node, s: without what free durations
  /// add.
  double time = 0, phase_time = 0, final_time = 0;
  /// How often the duration of each phase in which it is free counts in t and in the time of the
  /// phase. In the final time each counts once.
  std::vector<double> share, phase_share;

  /// Those of expressions (ExpressionResidualText): t, time of the phase, final time and the shares
  /// of free durations.
  void append_to(std::vector<double>& parameters) const;
};

/// The time when a share of a knot has passed, in a phase of a problem, from that of the knot and
/// its step, s.
NodeTime time_within(const NodeTime& knot, double step, double passed, const ProblemSpec& spec,
                     std::size_t phase);

/// Of all nodes, whose times with the durations of the file are given, s. `start`: what a clock in
/// the state shows at first, which then has t.
std::vector<NodeTime> node_times(const ProblemSpec& spec, const std::vector<double>& written,
                                 double start = 0);

}  // namespace conddp
