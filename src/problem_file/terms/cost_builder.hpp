#pragma once

#include "ocp/problem/problem.hpp"
#include "problem_file/model/node_time.hpp"
#include "problem_file/terms/reference_builder.hpp"
#include "problem_file/terms/term_residual.hpp"

namespace conddp {

/// A cost ready for knot models.
struct BuiltCost {
  const CostSpec* spec;
  CostResidual residual;
  ContactCost contact;  ///< contact costs: `residual` is its prototype
  Activation activation;
  TimeSeries reference;
  /// Index of its variant of the plant; absent in a plant without variants.
  std::optional<std::size_t> variant = {};

  /// True if it uses the states and controls of a phase, or of the last node, whose index is the
  /// number of phases.
  bool is_at(std::size_t phase, const Plant& plant) const {
    return !variant || plant.variant_at[phase] == *variant;
  }
};

/// Data of the problem for building costs.
struct CostContext {
  const ProblemSpec& spec;
  const Plant& plant;
  const ContactPlan& contacts;
  const StateBuilder& states;
  int ndx;                           ///< of the knot models, including augmented states
  const std::vector<double>& times;  ///< of the nodes
  bool last_node = false;            ///< terms at the last node, not on running knots
};

/// A plant for building a cost or constraint.
struct PlantOfCost {
  std::optional<std::size_t> variant;
  Plant plant;
};
/// The plants of the phases where a cost or constraint can be active; without variants the entire
/// plant. If the file does not name phases, a residual that needs a control skips plants without
/// controls.
std::vector<PlantOfCost> plants_of(const CostSpec& function, const CostContext& context);

/// Builds each cost once per active variant of the plant. Invalid costs are reported and omitted.
std::vector<BuiltCost> build_costs(const std::vector<CostSpec>& specs, const CostContext& context,
                                   Diagnostics& out);

/// Parameters of the residual at a node: the reference and, if it depends on it, the time.
std::vector<double> residual_parameters(const BuiltCost& cost, const NodeTime& time);

/// Writes a cost's parameters (reference, weight) at a node into those of a knot.
void write_parameters(const BuiltCost& cost, const CostTerm& term, const NodeTime& time,
                      double weight, double* parameters);

}  // namespace conddp
