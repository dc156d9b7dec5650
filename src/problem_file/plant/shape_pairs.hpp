#pragma once

#include "ocp/residuals/residuals.hpp"
#include "problem_file/plant/plant.hpp"

namespace conddp {

/// Two shapes of a problem file that must keep apart; a link carries the first one.
struct ShapePair {
  std::string first, second;  ///< names of the shapes
  DistancePair shapes;
};

/// The vertices of a box, of a prism of 32 faces around a cylinder, and of a hull, in the axes of
/// their frame.
Polytope polytope_of(const BoxSpec& box, int frame);
Polytope polytope_of(const CylinderSpec& cylinder, int frame);
Polytope polytope_of(const HullSpec& hull, int frame);

/// Reports shapes on frames that the robot lacks.
void check_shapes(const ProblemSpec& spec, const Plant& plant, Diagnostics& out);

/// The pairs of a cost, each once; requires shapes that pass check_shapes(). Reports unknown names,
/// and named pairs without relative motion.
std::vector<ShapePair> shape_pairs(const CostSpec& cost, const ProblemSpec& spec,
                                   const Plant& plant, Diagnostics& out);

}  // namespace conddp
