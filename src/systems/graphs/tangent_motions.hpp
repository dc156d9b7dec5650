#pragma once

#include <span>

#include "systems/graphs/derivatives.hpp"
#include "systems/state_manifold.hpp"

namespace conddp {

/// Motions of the inputs that hold a state along its tangent vectors; input_of[i] is the input that
/// holds number i of the state.
InputMotions tangent_motions(ExpressionGraph& graph, const StateManifold& manifold,
                             std::span<const int> input_of);

/// Motions of the inputs along the columns of z = (tangent at x, u). Input i is number sources[i]
/// of (x, u), and each number of x is an input.
InputMotions input_motions(ExpressionGraph& graph, const StateManifold& manifold,
                           std::span<const int> sources);

}  // namespace conddp
