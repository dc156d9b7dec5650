#pragma once

#include "problem_file/data/time_series.hpp"
#include "problem_file/motion/contact_plan.hpp"
#include "problem_file/motion/state_builder.hpp"
#include "problem_file/residuals/cost_residual.hpp"

namespace conddp {

/// Reference of a swinging frame, one value per knot: positions, or poses for frame_placement. It
/// covers every run of consecutive phases that the cost names, and the touch-down node after it.
/// The first swing starts at the initial position, later ones at the previous landing. Each is a
/// SwingArc, uniform in time: it lifts off and lands with zero velocity. Landings given by
/// displacements stay on the ground (see footholds), and over a terrain the arcs are raised (see
/// clearing_height). Invalid swings are reported: the frame is held meanwhile or never lifts, the
/// number of displacements differs from that of the swings, or there is no ground.
std::optional<TimeSeries> swing_reference(const CostSpec& cost, const CostResidual& residual,
                                          const ProblemSpec& spec, const ContactPlan& plan,
                                          const Plant& plant, const std::vector<double>& initial,
                                          const std::vector<double>& times, Diagnostics& out);

}  // namespace conddp
