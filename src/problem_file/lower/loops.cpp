#include "problem_file/lower/loops.hpp"

#include <algorithm>
#include <utility>

#include <fmt/format.h>

namespace conddp {
namespace {

void hold(const Name& name, ContactNames& contacts) {
  if (!contacts.all) contacts.names.push_back(name);
}

}  // namespace

void add_loops(ProblemSpec& spec, Diagnostics& out) {
  for (const LoopSpec& loop : std::exchange(spec.loops, {})) {
    const auto has_its_name = [&](const ContactSpec& contact) {
      return contact.name.value == loop.name.value;
    };
    if (std::ranges::any_of(spec.contacts, has_its_name))
      return out.error(loop.name.place,
                       fmt::format("a contact is called '{}', too", loop.name.value));
    ContactSpec& contact = spec.contacts.emplace_back(loop.contact);
    contact.name = loop.name;
    contact.placement = PoseSpec{.position = Vector3<double>{0, 0, 0}};
    if (contact.kind == ContactKind::surface)
      contact.placement->orientation = Quaternion<double>{0, 0, 0, 1};
    for (PhaseSpec& phase : spec.phases) hold(loop.name, phase.contacts);
    if (spec.terminal_contacts) hold(loop.name, *spec.terminal_contacts);
  }
}

}  // namespace conddp
