#pragma once

#include "ocp/residuals/residuals.hpp"
#include "problem_file/plant/plant.hpp"

namespace conddp {

/// Two shapes of a problem file that must keep apart; the first one is carried by a link.
struct ShapePair {
  std::string first, second;  ///< their names
  DistancePair shapes;
};

/// Frames of shapes that the robot has not are reported.
void check_shapes(const ProblemSpec& spec, const Plant& plant, Diagnostics& out);

/// The pairs that a cost is on, each once, of shapes that check_shapes() found good. Unknown names,
/// and pairs of shapes that cannot move against each other where they are named, are reported.
std::vector<ShapePair> shape_pairs(const CostSpec& cost, const ProblemSpec& spec,
                                   const Plant& plant, Diagnostics& out);

}  // namespace conddp
