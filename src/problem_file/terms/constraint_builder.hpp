#pragma once

#include "ocp/residuals/residual_by_duration.hpp"
#include "problem_file/terms/cost_builder.hpp"

namespace conddp {

/// A constraint ready to be put into knot models.
struct BuiltConstraint {
  const ConstraintSpec* spec = nullptr;
  BuiltCost function = {};  ///< residual and reference; of costs on contacts one of them
  ConstraintKind kind = ConstraintKind::bounds;
  double slope = 1;
  std::vector<double> lower, upper;  ///< a number per row of what is bounded
  bool at_last_node = false;         ///< of a constraint on running knots: there as well
};

/// Whether nothing is said about what the residual has to be, so that it has to be zero.
bool is_zero(const ConstraintSpec& constraint);

/// Constraints that cannot be built are reported and left out.
std::vector<BuiltConstraint> build_constraints(const std::vector<ConstraintSpec>& specs,
                                               const CostContext& context, Diagnostics& out);

/// Multiplies bounds of controls by a factor.
void scale_efforts(double scale, std::vector<double>& lower, std::vector<double>& upper);

/// The term for a knot model, with this residual. `duration`: where costs of the knot grow with a
/// free duration, that.
ConstraintTerm make_term(const BuiltConstraint& constraint,
                         std::shared_ptr<const Residual> residual,
                         const std::optional<DurationColumn>& duration = {});

/// Writes the numbers of a constraint at a node into the parameters of a knot.
void write_parameters(const BuiltConstraint& constraint, const ConstraintTerm& term,
                      const NodeTime& time, bool active, double* parameters);

}  // namespace conddp
