#pragma once

#include "ocp/residuals/residual_by_duration.hpp"
#include "problem_file/terms/cost_builder.hpp"

namespace conddp {

/// A constraint ready for knot models.
struct BuiltConstraint {
  const ConstraintSpec* spec = nullptr;
  BuiltCost function = {};  ///< residual and reference; contact costs: of one contact
  ConstraintKind kind = ConstraintKind::bounds;
  double slope = 1;
  std::vector<double> lower, upper;  ///< one number per row
  bool at_last_node = false;         ///< a constraint on running knots that also applies there
};

/// True without a set in the file: the residual must then be zero.
bool is_zero(const ConstraintSpec& constraint);

/// Builds constraints; invalid ones are reported and omitted.
std::vector<BuiltConstraint> build_constraints(const std::vector<ConstraintSpec>& specs,
                                               const CostContext& context, Diagnostics& out);

/// Multiplies control bounds by a factor.
void scale_efforts(double scale, std::vector<double>& lower, std::vector<double>& upper);

/// The term for a knot model with this residual. `duration`: free duration that scales costs of the
/// knot, if any.
ConstraintTerm make_term(const BuiltConstraint& constraint,
                         std::shared_ptr<const Residual> residual,
                         const std::optional<DurationColumn>& duration = {});

/// Writes the numbers of a constraint at a node into the parameters of a knot.
void write_parameters(const BuiltConstraint& constraint, const ConstraintTerm& term,
                      const NodeTime& time, bool active, double* parameters);

}  // namespace conddp
