#include "problem_file/residuals/contact_keys.hpp"

#include "problem_file/residuals/key_kinds.hpp"
#include "problem_file/values/expand_values.hpp"
#include "problem_file/values/read_values.hpp"
#include "problem_file/values/value_schema.hpp"

namespace conddp {

const ResidualKey& contacts_key() {
  static const ResidualKey contacts = {
      "contacts",
      "For residuals on contacts: one term per contact while it is held; by default all contacts, "
      "at the last node all that it holds",
      defined_schema("contact_names"),
      {},
      [](const YamlReader& reader, CostSpec& cost) {
        cost.keys.set(key::contacts, read_contact_names(reader));
      },
      [](const CostSpec& cost, const KeyContext& context) {
        const ContactNames names = cost.keys.value(key::contacts);
        const bool held = context.place.last_node && names.all;
        return expand_contact_names(held ? context.spec.last_contacts() : names, context.spec);
      }};
  return contacts;
}

}  // namespace conddp
