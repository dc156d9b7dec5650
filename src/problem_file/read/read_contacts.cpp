#include <cmath>

#include <fmt/format.h>

#include "problem_file/read/read_sections.hpp"
#include "problem_file/spec/enum_names.hpp"

namespace conddp {
namespace {

void read_baumgarte(const YamlReader& reader, ContactSpec& contact) {
  contact.baumgarte_place = reader.place();
  YamlMap map(reader);
  map.number("kp", contact.kp, kNotNegative);
  map.number("kd", contact.kd, kNotNegative);
}

void read_axes(YamlMap& map, ContactSpec& contact) {
  map.choice("axes", contact.axes, kAxesWords, "system of axes");
  if (const auto r = map.find("normal"))
    contact.normal = read_direction(*r).value_or(contact.normal);
  if (const auto r = map.find("tangent")) {
    contact.tangent = read_direction(*r);
    if (contact.kind != ContactKind::planar)
      r->error("'tangent' belongs to contacts of type 'planar'");
  }
}

void read_force_limits(YamlMap& map, ContactSpec& contact) {
  map.number("friction", contact.friction, kPositive);
  map.number("min_normal_force", contact.min_normal_force, kNotNegative);
  map.number("max_normal_force", contact.max_normal_force, kPositive);
  if (contact.min_normal_force >= contact.max_normal_force)
    map.reader().error(fmt::format("'min_normal_force' {} does not lie under 'max_normal_force' {}",
                                   contact.min_normal_force, contact.max_normal_force));
}

void read_size(const YamlReader& reader, ContactSpec& contact) {
  const auto size = reader.numbers(2, "[length, width] of a sole along its x and y, in m");
  if (size && (*size)[0] > 0 && (*size)[1] > 0)
    contact.half_size = {(*size)[0] / 2, (*size)[1] / 2};
  else if (size)
    reader.error("the size of a sole must be positive");
}

/// Reads the keys that `defaults` also accepts.
void read_common_keys(YamlMap& map, ContactSpec& contact) {
  map.choice("type", contact.kind, kContactWords, "type of contact");
  read_axes(map, contact);
  if (const auto r = map.find("baumgarte")) read_baumgarte(*r, contact);
  read_force_limits(map, contact);
  if (const auto r = map.find("size")) read_size(*r, contact);
}

void complete_tangent(const Place& place, Diagnostics& out, ContactSpec& contact) {
  if (contact.kind != ContactKind::planar) return;
  const Vector3<double> n = contact.normal;
  // By default the world's (or the frame's) x axis, projected onto the plane.
  Vector3<double> t = contact.tangent.value_or(Vector3<double>{1, 0, 0});
  t = t - dot(n, t) * n;
  const double length = std::sqrt(squared_norm(t));
  if (length < 1e-3) {
    out.error(place, "the tangent of a planar contact must not be along its normal",
              "give 'tangent'");
    return;
  }
  contact.tangent = (1 / length) * t;
}

/// Defaults for all contacts.
ContactSpec read_defaults(const std::vector<std::pair<Name, YamlReader>>& entries) {
  ContactSpec defaults;
  for (const auto& [name, value] : entries) {
    if (name.value != "defaults") continue;
    YamlMap map(value);
    read_common_keys(map, defaults);
  }
  return defaults;
}

ContactSpec read_contact(const Name& name, const YamlReader& reader, const ContactSpec& defaults) {
  if (name.value == "all" || name.value.find_first_of("/,") != std::string::npos)
    reader.diagnostics().error(name.place,
                               fmt::format("'{}' cannot be the name of a contact", name.value),
                               "'all' stands for every contact, and names have no '/' and no ','");
  ContactSpec contact = defaults;
  contact.name = name;
  YamlMap map(reader);
  if (const auto r = map.require("frame")) contact.frame = r->name().value_or(contact.frame);
  read_common_keys(map, contact);
  if (const auto r = map.find("placement")) {
    contact.placement = read_pose(*r);
    if (contact.kp == 0) r->error("'placement' counts where 'baumgarte' has a 'kp' only");
  }
  if (contact.baumgarte_place.path.empty()) contact.baumgarte_place = name.place;
  complete_tangent(name.place, reader.diagnostics(), contact);
  return contact;
}

}  // namespace

std::optional<Vector3<double>> read_direction(const YamlReader& reader) {
  const auto v = read_vector3(reader, "a direction [x, y, z]");
  if (!v) return std::nullopt;
  const double length = std::sqrt(squared_norm(*v));
  if (length > 1e-6) return unit_scale(length) * *v;
  reader.error("a direction of length 0");
  return std::nullopt;
}

std::vector<ContactSpec> read_contacts(const YamlReader& reader) {
  std::vector<ContactSpec> contacts;
  const auto entries = reader.named_entries("write '{LF: {frame: lf_foot}}'");
  if (!entries) return contacts;
  const ContactSpec defaults = read_defaults(*entries);
  for (const auto& [name, value] : *entries)
    if (name.value != "defaults") contacts.push_back(read_contact(name, value, defaults));
  return contacts;
}

}  // namespace conddp
