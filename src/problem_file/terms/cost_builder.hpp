#pragma once

#include "ocp/problem/problem.hpp"
#include "problem_file/spec/node_time.hpp"
#include "problem_file/terms/reference_builder.hpp"
#include "problem_file/terms/term_residual.hpp"

namespace conddp {

/// A cost ready to be put into knot models.
struct BuiltCost {
  const CostSpec* spec;
  CostResidual residual;
  ContactCost contact;  ///< of costs on contacts: `residual` is its prototype
  Activation activation;
  TimeSeries reference;
  /// Which variant of the plant it is of; nothing where the plant has none.
  std::optional<std::size_t> variant = {};

  /// Whether it is of the states and controls that there are in a phase, or at the last node, whose
  /// number is that of the phases.
  bool is_at(std::size_t phase, const Plant& plant) const {
    return !variant || plant.variant_at[phase] == *variant;
  }
};

/// What building costs needs to know of the problem.
struct CostContext {
  const ProblemSpec& spec;
  const Plant& plant;
  const ContactPlan& contacts;
  const StateBuilder& states;
  int ndx;                           ///< of the knot models, augmented states included
  const std::vector<double>& times;  ///< of the nodes
  bool last_node = false;            ///< whether they stand there, not on running knots
};

/// One of the plants on which a cost or constraint is built.
struct PlantOfCost {
  std::optional<std::size_t> variant;
  Plant plant;
};
/// The plants of the phases in which a cost or constraint can be on; the whole plant where it has
/// no variants. Where the file does not name phases, those without any control are left out of what
/// needs one.
std::vector<PlantOfCost> plants_of(const CostSpec& function, const CostContext& context);

/// A cost is built once for each variant of the plant on which it is. Costs that cannot be built
/// are reported and left out.
std::vector<BuiltCost> build_costs(const std::vector<CostSpec>& specs, const CostContext& context,
                                   Diagnostics& out);

/// What its residual takes as parameters at a node: the reference and, where it reads it, the time.
std::vector<double> residual_parameters(const BuiltCost& cost, const NodeTime& time);

/// Writes a cost's parameters (reference, weight) at a node into those of a knot.
void write_parameters(const BuiltCost& cost, const CostTerm& term, const NodeTime& time,
                      double weight, double* parameters);

}  // namespace conddp
