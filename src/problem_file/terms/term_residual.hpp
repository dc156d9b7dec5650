#pragma once

#include "problem_file/motion/contact_plan.hpp"
#include "problem_file/residuals/cost_residual.hpp"

namespace conddp {

/// Makes the residual of a cost or constraint for knot models with `ndx` tangent coordinates; empty
/// for contact residuals. A residual that does not fit the plant is reported.
std::optional<CostResidual> make_cost_residual(const CostSpec& cost, const ProblemSpec& spec,
                                               const Plant& plant, int ndx, Diagnostics& out);

/// True if a cost needs held contacts: its residual is on contacts, or its rows read them.
bool is_on_contacts(const CostSpec& cost);

/// A contact cost's residual in a system that holds only its contacts.
std::shared_ptr<const Residual> make_prototype(const ContactCost& cost, const ContactPlan& plan,
                                               const Plant& plant);

/// One contact cost for each contact that `cost` names, or one on all contacts that its rows read.
/// Residuals that do not fit are reported.
std::vector<ContactCost> make_contact_costs(const CostSpec& cost, const ProblemSpec& spec,
                                            const ContactPlan& plan, const Plant& plant, int ndx,
                                            Diagnostics& out);

}  // namespace conddp
