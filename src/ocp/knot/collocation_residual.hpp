#pragma once

#include <optional>
#include <vector>

#include "ocp/knot/knot_model.hpp"

namespace conddp {

/// h (k_i − f(x_i, u)), one stage of a collocation system after the other: what its steps have to
/// obey. Rows have the units of what the slopes integrate to, of velocities or of the state. ndx is
/// that of the knot model; with a free duration the step follows the number in the state. `linear`:
/// of knots with linear controls, where u is that of the stage. Parameter: the step h, s, as
/// written.
std::shared_ptr<const Residual> collocation_residual(
    std::shared_ptr<const CollocationSystem> system, int ndx,
    const std::optional<FreeDuration>& duration = std::nullopt, bool linear = false);

}  // namespace conddp
