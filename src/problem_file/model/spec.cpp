#include "problem_file/model/spec.hpp"

#include <algorithm>

namespace conddp {

namespace {

template <class Term>
std::vector<const Term*> in_one_list(const std::vector<Term>& running,
                                     const std::vector<Term>& terminal) {
  std::vector<const Term*> all;
  for (const auto* list : {&running, &terminal})
    for (const Term& term : *list) all.push_back(&term);
  return all;
}

}  // namespace

std::vector<const CostSpec*> ProblemSpec::all_costs() const {
  std::vector<const CostSpec*> all = in_one_list(costs, integrals);
  for (const CostSpec& cost : terminal_costs) all.push_back(&cost);
  return all;
}

std::vector<const ConstraintSpec*> ProblemSpec::all_constraints() const {
  return in_one_list(constraints, terminal_constraints);
}

const CostSpec* ProblemSpec::first_use(bool ResidualNeeds::*need) const {
  const auto has_need = [need](const CostSpec& cost) {
    return cost.definition->needs.*need ||
           (need == &ResidualNeeds::previous_control && cost.names_previous_control);
  };
  for (const CostSpec* cost : all_costs())
    if (has_need(*cost)) return cost;
  for (const ConstraintSpec* constraint : all_constraints())
    if (!constraint->bounded && has_need(constraint->function)) return &constraint->function;
  return nullptr;
}

std::string_view ProblemSpec::use_of_previous_control() const {
  const CostSpec* use = first_use(&ResidualNeeds::previous_control);
  if (use == nullptr) return "";
  return use->names_previous_control ? "previous" : use->definition->name;
}

bool ProblemSpec::has_jumps() const {
  return std::any_of(phases.begin(), phases.end(),
                     [](const PhaseSpec& phase) { return phase.jump.has_value(); });
}

ContactNames ProblemSpec::named(const ContactNames& contacts_chosen) const {
  if (!contacts_chosen.all) return contacts_chosen;
  ContactNames all;
  for (const ContactSpec& contact : contacts) all.names.push_back(contact.name);
  return all;
}

ContactNames ProblemSpec::named_in_term(const ContactNames& contacts_chosen, bool last_node) const {
  if (!contacts_chosen.all) return contacts_chosen;
  ContactNames chosen = named(last_node ? last_contacts() : contacts_chosen);
  std::erase_if(chosen.names, [&](const Name& own) {
    const auto found = std::ranges::find_if(
        contacts, [&](const ContactSpec& contact) { return contact.name.value == own.value; });
    return found != contacts.end() && found->to;
  });
  return chosen;
}

ProblemSpec::ProblemSpec() = default;
ProblemSpec::ProblemSpec(const ProblemSpec& other) = default;
ProblemSpec::ProblemSpec(ProblemSpec&& other) noexcept = default;
ProblemSpec& ProblemSpec::operator=(const ProblemSpec& other) = default;
ProblemSpec& ProblemSpec::operator=(ProblemSpec&& other) noexcept = default;
ProblemSpec::~ProblemSpec() = default;

const PhaseSpec* ProblemSpec::first_free_duration() const {
  for (const PhaseSpec& phase : phases)
    if (phase.free_duration) return &phase;
  return nullptr;
}

}  // namespace conddp
