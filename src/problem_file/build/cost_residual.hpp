#pragma once

#include <memory>
#include <optional>
#include <vector>

#include "problem_file/plant/plant.hpp"
#include "problem_file/spec/components.hpp"

namespace conddp {

/// A cost's residual on a given plant and what the rest of the cost has to know about it.
struct CostResidual {
  std::shared_ptr<const Residual> residual;
  ComponentNames rows;        ///< what weights and bounds are named by
  StateManifold parameters;   ///< where references live
  ComponentNames references;  ///< what a reference given in numbers is named by
  std::vector<int> indices;   ///< into state or velocity, of residuals on chosen coordinates
  int frame = -1;
  std::vector<double> lower, upper;  ///< the robot's own limits of the rows, empty if it has none
};

/// Makes the residual for knot models with `ndx` tangent coordinates; what does not fit the plant
/// is reported.
std::optional<CostResidual> make_cost_residual(const CostSpec& cost, const ProblemSpec& spec,
                                               const Plant& plant, int ndx, Diagnostics& out);

}  // namespace conddp
