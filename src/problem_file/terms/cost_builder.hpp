#pragma once

#include "ocp/problem/problem.hpp"
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
};

/// What building costs needs to know of the problem.
struct CostContext {
  const ProblemSpec& spec;
  const Plant& plant;
  const ContactPlan& contacts;
  const StateBuilder& states;
  int ndx;                           ///< of the knot models, augmented states included
  const std::vector<double>& times;  ///< of the nodes
};

/// Costs that cannot be built are reported and left out.
std::vector<BuiltCost> build_costs(const std::vector<CostSpec>& specs, const CostContext& context,
                                   Diagnostics& out);

/// What its residual takes as parameters at a time (s): the reference and, where it reads it, the
/// time.
std::vector<double> residual_parameters(const BuiltCost& cost, double time);

/// Writes a cost's parameters (reference, weight) at a time into those of a knot.
void write_parameters(const BuiltCost& cost, const CostTerm& term, double time, double weight,
                      double* parameters);

}  // namespace conddp
