#pragma once

#include <functional>

#include "problem_file/build/contact_plan.hpp"
#include "problem_file/build/cost_residual.hpp"

namespace conddp {

/// A cost on the force of one contact. The residual depends on the system in which the contact is
/// held, so that each phase makes its own.
struct ContactCost {
  int contact = -1;  ///< into the file's contacts
  std::function<std::shared_ptr<const Residual>(const std::shared_ptr<const MultibodySystem>&,
                                                int index)>
      make;
  CostResidual prototype;            ///< of a system that holds this contact alone
  std::vector<double> lower, upper;  ///< bounds that a cone brings along
};

/// One for each contact that the cost names; what does not fit is reported.
std::vector<ContactCost> make_contact_costs(const CostSpec& cost, const ProblemSpec& spec,
                                            const ContactPlan& plan, const Plant& plant, int ndx,
                                            Diagnostics& out);

}  // namespace conddp
