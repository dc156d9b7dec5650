#pragma once

#include <vector>

#include "problem_file/plant/plant.hpp"

namespace conddp {

/// True if a problem supports linear controls or has constant ones. Conflicts are reported at their
/// places.
bool check_linear_controls(const ProblemSpec& spec, const System& system, Diagnostics& out);

/// Weights of a term at each node, and of its separate part there.
struct NodeWeights {
  std::vector<double> nodes;
  /// Weights of the ends of knots in phases with other durations; empty without such phases.
  std::vector<double> ends = {};

  double end(int node) const { return ends.empty() ? 0.0 : ends[node]; }
};

/// Converts weights of knots to weights of nodes: with linear controls, a cost applies at both ends
/// of a knot, half each (trapezoidal rule). Both are relative to the factor on the costs of the
/// node: `scales` has one for each knot, and that of the last node is 1. `apart`: true for nodes
/// with separate weights for the end of the previous knot.
NodeWeights trapezoidal_weights(const std::vector<double>& weights,
                                const std::vector<double>& scales, const std::vector<bool>& apart);

}  // namespace conddp
