#include "problem_file/residuals/cost_residual.hpp"
#include "problem_file/residuals/reference_form.hpp"
#include "problem_file/residuals/residual_table.hpp"

namespace conddp {
namespace {

std::optional<CostResidual> make_control(const ResidualContext& context) {
  const System& actuated = context.plant.actuated();
  CostResidual result;
  result.residual = control_residual(context.ndx, actuated.nu());
  result.rows = result.references = control_names(context.plant);
  result.parameters = StateManifold::flat(actuated.nu());
  result.lower = actuated.control_lower();
  result.upper = actuated.control_upper();
  result.columns = result.rows.names;
  return result;
}

std::optional<CostResidual> make_control_rate(const ResidualContext& context) {
  CostResidual result;
  const System& actuated = context.plant.actuated();
  result.residual = control_rate_residual(actuated, context.ndx - actuated.ndx() - actuated.nu());
  result.rows = control_names(context.plant);
  return result;
}

}  // namespace

std::span<const ResidualDefinition> control_residuals() {
  static const ResidualDefinition all[] = {
      {.name = "control",
       .description = "the control minus a reference",
       .unit = "same as the controls",
       .synonyms = {"torque", "torques", "effort", "input", "u"},
       .needs = {.control = true},
       .reference = &kControlReference,
       .has_limits = true,
       .is_point = [](const CostSpec&) { return true; },
       .make = make_control},
      {.name = "control_rate",
       .description = "the control minus the one before",
       .unit = "same as the controls",
       .synonyms = {"jerk", "smoothness", "control_change"},
       .needs = {.control = true, .previous_control = true},
       .make = make_control_rate}};
  return all;
}

}  // namespace conddp
