#pragma once

#include <vector>

#include "problem_file/plant/plant.hpp"

namespace conddp {

/// Whether a problem can have linear controls; what they cannot go together with is reported at the
/// place that says so. True where controls are constant.
bool check_linear_controls(const ProblemSpec& spec, const System& system, Diagnostics& out);

/// A weight for each node, and what counts by itself there.
struct NodeWeights {
  std::vector<double> nodes;
  /// Of the ends of knots that belong to phases with other durations; no numbers: there are none.
  std::vector<double> ends = {};

  double end(int node) const { return ends.empty() ? 0.0 : ends[node]; }
};

/// From weights of the knots: with linear controls a cost counts at both ends of a knot, half each
/// (the trapezoidal rule). Both are multiples of the node's `scales`, what its costs are multiplied
/// by, one for each knot; that of the last node is 1. `apart`: at which nodes the ends of the knots
/// before them count by themselves.
NodeWeights trapezoidal_weights(const std::vector<double>& weights,
                                const std::vector<double>& scales, const std::vector<bool>& apart);

}  // namespace conddp
