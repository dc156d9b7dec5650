#pragma once

#include <optional>
#include <vector>

#include "ocp/knot/knot_model.hpp"

namespace conddp {

/// Collocation equations h (k_i − f(x_i, u)), one stage after the other. Rows have the units of the
/// integrated slopes: velocities or states. `ndx` is that of the knot model. With a free duration,
/// the step scales with the duration in the state. `linear`: the knots have linear controls, and u
/// is the control at the stage. Parameter: the step h as written, s.
std::shared_ptr<const Residual> collocation_residual(
    std::shared_ptr<const CollocationSystem> system, int ndx,
    const std::optional<FreeDuration>& duration = std::nullopt, bool linear = false);

}  // namespace conddp
