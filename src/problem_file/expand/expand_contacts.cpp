#include "problem_file/expand/expand_sections.hpp"
#include "problem_file/spec/enum_names.hpp"

namespace conddp {

OrderedJson expand_contacts(const std::vector<ContactSpec>& contacts) {
  OrderedJson json = OrderedJson::object();
  for (const ContactSpec& contact : contacts) {
    OrderedJson entry = {{"frame", contact.frame.value},
                         {"type", word_of(kContactWords, contact.kind)},
                         {"axes", word_of(kAxesWords, contact.axes)},
                         {"normal", expand_vector(contact.normal)}};
    if (contact.kind == ContactKind::planar) entry["tangent"] = expand_vector(*contact.tangent);
    if (contact.half_size)
      entry["size"] = {2 * (*contact.half_size)[0], 2 * (*contact.half_size)[1]};
    entry["friction"] = contact.friction;
    entry["min_normal_force"] = contact.min_normal_force;
    if (contact.max_normal_force < kUnlimited) entry["max_normal_force"] = contact.max_normal_force;
    entry["baumgarte"] = {{"kp", contact.kp}, {"kd", contact.kd}};
    if (contact.placement) entry["placement"] = expand_pose(*contact.placement);
    json[contact.name.value] = std::move(entry);
  }
  return json;
}

}  // namespace conddp
