#pragma once

#include <functional>
#include <memory>
#include <optional>
#include <vector>

#include "ocp/residuals/residuals.hpp"
#include "problem_file/plant/plant.hpp"
#include "problem_file/spec/components.hpp"

namespace conddp {

/// From what a residual is made, for knot models with `ndx` tangent coordinates.
struct ResidualContext {
  const CostSpec& cost;
  const ProblemSpec& spec;
  const Plant& plant;
  const std::vector<Contact>& contacts;  ///< of the file; empty for residuals that are of none
  int ndx;
  Diagnostics& out;
};

/// What of the time of its node a residual takes as parameters, behind its reference.
enum class TimeParameters {
  kNone,
  kTime,  ///< t, s
  kAll    ///< those of NodeTime
};

/// A cost's residual on a given plant and what the rest of the cost has to know about it.
struct CostResidual {
  std::shared_ptr<const Residual> residual;
  ComponentNames rows;       ///< what weights and bounds are named by
  StateManifold parameters;  ///< where references live
  TimeParameters time = TimeParameters::kNone;
  ComponentNames references;  ///< what a reference given in numbers is named by
  std::vector<int> indices;   ///< into state or velocity, of residuals on chosen coordinates
  int frame = -1;
  std::vector<double> lower, upper;  ///< the robot's own limits of the rows, empty if it has none
  /// The parameters that a state of the system gives; null if references are not of states.
  std::function<std::vector<double>(const std::vector<double>& x)> in_state;
  std::vector<std::string> columns;  ///< of trajectories, that hold it; empty: there are none
};

/// The residual of one contact, or of several. It depends on the system in which these are held, so
/// that each phase makes its own.
struct ContactCost {
  std::vector<int> contacts;  ///< into the file's contacts
  /// In a system that holds all of them, each at its index there.
  std::function<std::shared_ptr<const Residual>(const std::shared_ptr<const MultibodySystem>&,
                                                const std::vector<int>& indices)>
      make;
  CostResidual prototype;            ///< of a system that holds these contacts alone
  std::vector<double> lower, upper;  ///< bounds that a cone brings along
};

}  // namespace conddp
