#pragma once

#include <functional>
#include <memory>
#include <optional>
#include <vector>

#include "ocp/residuals/residuals.hpp"
#include "problem_file/model/components.hpp"
#include "problem_file/plant/plant.hpp"

namespace conddp {

/// Context for making a residual for knot models with `ndx` tangent coordinates.
struct ResidualContext {
  const CostSpec& cost;
  const ProblemSpec& spec;
  const Plant& plant;
  const std::vector<Contact>& contacts;  ///< of the file; empty for residuals without contacts
  int ndx;
  Diagnostics& out;
};

/// Time parameters of a residual at its node, which follow its reference.
enum class TimeParameters {
  kNone,
  kTime,  ///< t, s
  kAll    ///< all of NodeTime
};

/// A cost's residual on a given plant, with data for the rest of the cost.
struct CostResidual {
  std::shared_ptr<const Residual> residual;
  ComponentNames rows;       ///< names for weights and bounds
  StateManifold parameters;  ///< manifold of the references
  TimeParameters time = TimeParameters::kNone;
  ComponentNames references;  ///< names for references given in numbers
  std::vector<int> indices;   ///< into state or velocity, for residuals on chosen coordinates
  int frame = -1;
  std::vector<double> lower, upper;  ///< the robot's limits of the rows; may be empty
  /// The parameters for a state of the system; null if states give no reference.
  std::function<std::vector<double>(const std::vector<double>& x)> in_state;
  std::vector<std::string> columns;  ///< of trajectories, that contain it; may be empty
};

/// The residual of one contact or of several. It depends on the system that holds them, so each
/// phase makes its own.
struct ContactCost {
  std::vector<int> contacts;  ///< into the file's contacts
  /// Makes it in a system that holds all of them, each at its index there.
  std::function<std::shared_ptr<const Residual>(const std::shared_ptr<const MultibodySystem>&,
                                                const std::vector<int>& indices)>
      make;
  CostResidual prototype;            ///< in a system that holds only these contacts
  std::vector<double> lower, upper;  ///< bounds that a cone defines
};

}  // namespace conddp
