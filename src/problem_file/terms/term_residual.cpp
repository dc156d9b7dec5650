#include "problem_file/terms/term_residual.hpp"

#include <numeric>

#include <fmt/format.h>

namespace conddp {
namespace {

/// True if the system has the control that a residual needs; reports an error otherwise.
bool has_its_control(const CostSpec& cost, const CostResidual& made, const Plant& plant,
                     Diagnostics& out) {
  const bool lacks_actuator = cost.definition->needs.control && plant.actuated().nu() == 0;
  const bool lacks_control = made.residual->needs_control() && plant.system->nu() == 0;
  if (!lacks_actuator && !lacks_control) return true;
  out.error(cost.residual.place,
            fmt::format("the residual '{}' needs a control, and the system has none",
                        cost.definition->name),
            "use residuals of the state, or give the system controls");
  return false;
}

}  // namespace

std::optional<CostResidual> make_cost_residual(const CostSpec& cost, const ProblemSpec& spec,
                                               const Plant& plant, int ndx, Diagnostics& out) {
  const ResidualDefinition& definition = *cost.definition;
  if (definition.needs.robot && !plant.multibody()) {
    out.error(cost.residual.place,
              fmt::format("the residual '{}' needs a robot; this is a closed-form system",
                          definition.name),
              "use 'state' (with 'columns') and 'control'");
    return std::nullopt;
  }
  if (definition.make == nullptr) return std::nullopt;
  const std::vector<Contact> none;
  auto made = definition.make({cost, spec, plant, none, ndx, out});
  if (made && !has_its_control(cost, *made, plant, out)) return std::nullopt;
  return made;
}

bool is_on_contacts(const CostSpec& cost) {
  const ResidualDefinition& definition = *cost.definition;
  return definition.of_contacts() ||
         (definition.reads_contacts != nullptr && definition.reads_contacts(cost));
}

std::shared_ptr<const Residual> make_prototype(const ContactCost& cost, const ContactPlan& plan,
                                               const Plant& plant) {
  std::vector<Contact> held;
  for (const int contact : cost.contacts) held.push_back(plan.contacts()[contact]);
  std::vector<int> indices(held.size());
  std::iota(indices.begin(), indices.end(), 0);
  return cost.make(plant.multibody()->with_contacts(held), indices);
}

std::vector<ContactCost> make_contact_costs(const CostSpec& cost, const ProblemSpec& spec,
                                            const ContactPlan& plan, const Plant& plant, int ndx,
                                            Diagnostics& out) {
  std::vector<ContactCost> costs;
  const ResidualContext context{cost, spec, plant, plan.contacts(), ndx, out};
  const auto add = [&](std::optional<ContactCost> one) {
    if (!one) return;
    one->prototype.residual = make_prototype(*one, plan, plant);
    if (has_its_control(cost, one->prototype, plant, out)) costs.push_back(std::move(*one));
  };
  if (!cost.definition->of_contacts()) {
    add(cost.definition->make_on_contacts(context));
    return costs;
  }
  const ContactNames names = cost.keys.value(key::contacts);
  const std::vector<int> chosen = contacts_named(spec.named_in_term(names, false), spec, out);
  if (chosen.empty() && names.all)
    out.error(
        cost.residual.place,
        fmt::format("'{}' is on contacts with the world, and the file has none", cost.name.value),
        "name them: 'contacts: {LF: {frame: lf_foot}, ...}' at the top of the file");
  for (const int contact : chosen) {
    auto one = cost.definition->make_of_contact(context, contact);
    if (one) one->contacts = {contact};
    add(std::move(one));
  }
  return costs;
}

}  // namespace conddp
