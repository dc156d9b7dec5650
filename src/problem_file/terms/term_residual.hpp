#pragma once

#include "problem_file/motion/contact_plan.hpp"
#include "problem_file/residuals/cost_residual.hpp"

namespace conddp {

/// Makes the residual of a cost or constraint for knot models with `ndx` tangent coordinates;
/// nothing of one on contacts. What does not fit the plant is reported.
std::optional<CostResidual> make_cost_residual(const CostSpec& cost, const ProblemSpec& spec,
                                               const Plant& plant, int ndx, Diagnostics& out);

/// Whether a cost stands on contacts that have to be held: it is of them, or its rows read them.
bool is_on_contacts(const CostSpec& cost);

/// A contact cost's residual in a system that holds its contacts alone.
std::shared_ptr<const Residual> make_prototype(const ContactCost& cost, const ContactPlan& plan,
                                               const Plant& plant);

/// One for each contact that the cost names, or one on all contacts that its rows read; what does
/// not fit is reported.
std::vector<ContactCost> make_contact_costs(const CostSpec& cost, const ProblemSpec& spec,
                                            const ContactPlan& plan, const Plant& plant, int ndx,
                                            Diagnostics& out);

}  // namespace conddp
