#include <cmath>

#include <fmt/format.h>

#include "problem_file/model/enum_names.hpp"
#include "problem_file/read/read_sections.hpp"

namespace conddp {
namespace {

/// The defaults of all contacts.
struct ContactDefaults {
  ContactSpec contact;
};

/// Length and width, of which the contact keeps the halves.
void read_size(const YamlReader& reader, ContactSpec& contact) {
  const auto size = reader.numbers(2, "[length, width] of a sole along its x and y, in m");
  if (size && (*size)[0] > 0 && (*size)[1] > 0)
    contact.half_size = {(*size)[0] / 2, (*size)[1] / 2};
  else if (size)
    reader.error("the size of a sole must be positive");
}

std::optional<OrderedJson> expand_size(const ContactSpec& contact) {
  if (!contact.half_size) return std::nullopt;
  return OrderedJson{2 * (*contact.half_size)[0], 2 * (*contact.half_size)[1]};
}

void check_common(YamlMap& map, const ContactSpec& contact) {
  if (const auto r = map.find("tangent"); r && contact.kind != ContactKind::planar)
    r->error("'tangent' belongs to contacts of type 'planar'");
  if (contact.min_normal_force >= contact.max_normal_force)
    map.reader().error(fmt::format("'min_normal_force' {} does not lie under 'max_normal_force' {}",
                                   contact.min_normal_force, contact.max_normal_force));
}

/// What a contact holds. `fallback`: "none" in `defaults`, as the schema shows defaults once.
void describe_kind(Keys& keys, std::string_view fallback, ContactSpec& contact) {
  const auto key = [&](std::string_view name, std::string_view says) {
    return KeyInfo{.name = name, .says = says, .fallback = fallback};
  };
  keys(key("type",
           "What is held: the point of the frame's origin, the whole frame, the point along the "
           "normal, or along normal and tangent"),
       contact.kind, WordForm{kContactWords, "type of contact"});
  keys(key("axes", "Axes in which normal and tangent are given and stay"), contact.axes,
       WordForm{kAxesWords, "system of axes"});
  keys(key("normal", "Direction of the surface's normal, without unit; its length does not matter"),
       contact.normal, DirectionForm{});
  keys(key("tangent",
           "Of planar contacts: the second direction, without unit; by default the x axis as far "
           "as it lies in the surface"),
       contact.tangent, DirectionForm{});
}

void describe_stabilization(Keys& keys, std::string_view fallback, ContactSpec& contact) {
  keys({"baumgarte", "Stabilization: acceleration = -kd * velocity - kp * error"},
       GroupValue([&contact, fallback](Keys& baumgarte) {
         if (YamlMap* map = baumgarte.reading()) contact.baumgarte_place = map->reader().place();
         baumgarte.about({.title = "Stabilization", .examples = R"([{"kd": 50}])"});
         baumgarte({.name = "kp", .says = "Stiffness, 1/s²", .fallback = fallback}, contact.kp,
                   NumberForm{kNotNegative});
         baumgarte({.name = "kd", .says = "Damping, 1/s", .fallback = fallback}, contact.kd,
                   NumberForm{kNotNegative});
       }));
}

/// The keys that `defaults` has, too.
void describe_common(Keys& keys, std::string_view fallback, ContactSpec& contact) {
  const auto key = [&](std::string_view name, std::string_view says) {
    return KeyInfo{.name = name, .says = says, .fallback = fallback};
  };
  describe_kind(keys, fallback, contact);
  keys({"size", "Of a sole: length and width along the frame's x and y about its origin, m"},
       CustomValue{[&contact](const YamlReader& reader) { read_size(reader, contact); },
                   [&contact] { return expand_size(contact); },
                   R"({"type": "array", "items": {"type": "number", "exclusiveMinimum": 0},
                       "minItems": 2, "maxItems": 2})"});
  keys(key("friction", "Coefficient of friction, without unit"), contact.friction,
       NumberForm{kPositive});
  keys(key("min_normal_force", "What cones hold the normal force above, N"),
       contact.min_normal_force, NumberForm{kNotNegative});
  keys(key("max_normal_force",
           "What cones hold the normal force under, N; without limit by default"),
       contact.max_normal_force, NumberForm{kPositive});
  describe_stabilization(keys, fallback, contact);
  if (YamlMap* map = keys.reading()) check_common(*map, contact);
}

void complete_tangent(const Place& place, Diagnostics& out, ContactSpec& contact) {
  if (contact.kind != ContactKind::planar) return contact.tangent.reset();
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

void check_name(const Name& name, Diagnostics& out) {
  if (name.value == "all" || name.value.find_first_of("/,") != std::string::npos)
    out.error(name.place, fmt::format("'{}' cannot be the name of a contact", name.value),
              "'all' stands for every contact, and names have no '/' and no ','");
}

ContactSpec read_contact(const Name& name, const YamlReader& reader, const ContactSpec& defaults) {
  check_name(name, reader.diagnostics());
  ContactSpec contact = defaults;
  contact.name = name;
  read_map(reader, contact);
  if (contact.baumgarte_place.path.empty()) contact.baumgarte_place = name.place;
  complete_tangent(name.place, reader.diagnostics(), contact);
  return contact;
}

}  // namespace

static void describe(Keys& keys, ContactDefaults& defaults) {
  keys.about({.definition = "contact_defaults",
              .title = "Contact defaults",
              .says = "Defaults for all contacts",
              .examples = R"([{"friction": 0.6, "baumgarte": {"kd": 50}}])"});
  describe_common(keys, "none", defaults.contact);
}

static void describe(Keys& keys, ContactSpec& contact) {
  keys.about({.definition = "contact",
              .title = "Contact",
              .says = "A frame that can touch the world or another frame",
              .examples = R"([{"frame": "lf_foot", "friction": 0.6},
                              {"frame": "hand", "to": "box", "type": "surface"}])"});
  keys({.name = "frame", .says = "Frame whose origin is the point of contact", .required = true},
       contact.frame, NameForm{});
  keys({"to",
        "Frame that it touches, of the same robot or another one, in place of the world; axes of "
        "the world are those of this frame then"},
       contact.to, NameForm{});
  describe_common(keys, "", contact);
  keys({"placement",
        "Where baumgarte's kp draws the frame to: position (m) and, of a surface, orientation; by "
        "default where it is in the initial state and, after a swing of the frame, where that "
        "lands"},
       contact.placement, MapForm{});
  if (const auto r = keys.found("placement"); r && contact.kp == 0)
    r->error("'placement' counts where 'baumgarte' has a 'kp' only");
}

void describe(Keys& keys, LoopSpec& loop) {
  ContactSpec& contact = loop.contact;
  keys.about({.definition = "loop",
              .title = "Loop",
              .says = "Two frames that are always together",
              .examples = R"([{"frame": "rod_end", "to": "crank_pin"}])"});
  keys({.name = "frame",
        .says = "Frame whose motion relative to the other is held",
        .required = true},
       contact.frame, NameForm{});
  keys({.name = "to", .says = "The other frame, where its origin is", .required = true}, contact.to,
       NameForm{});
  describe_kind(keys, "", contact);
  describe_stabilization(keys, "", contact);
  YamlMap* map = keys.reading();
  if (map == nullptr) return;
  check_name(loop.name, map->reader().diagnostics());
  check_common(*map, contact);
  complete_tangent(map->reader().place(), map->reader().diagnostics(), contact);
  if (contact.baumgarte_place.path.empty()) contact.baumgarte_place = loop.name.place;
}

bool ContactsForm::read(const YamlReader& reader, std::vector<ContactSpec>& contacts) const {
  const auto entries = reader.named_entries("write '{LF: {frame: lf_foot}}'");
  if (!entries) return false;
  ContactDefaults defaults;
  for (const auto& [name, value] : *entries)
    if (name.value == "defaults") read_map(value, defaults);
  for (const auto& [name, value] : *entries)
    if (name.value != "defaults") contacts.push_back(read_contact(name, value, defaults.contact));
  return true;
}

std::optional<OrderedJson> ContactsForm::expand(const std::vector<ContactSpec>& contacts) const {
  if (contacts.empty()) return std::nullopt;
  OrderedJson json = OrderedJson::object();
  for (const ContactSpec& contact : contacts) json[contact.name.value] = expand_map(contact);
  return json;
}

OrderedJson ContactsForm::schema(const std::vector<ContactSpec>& /*names the type*/,
                                 SchemaDefinitions& definitions) const {
  return {{"type", "object"},
          {"properties", {{"defaults", map_schema<ContactDefaults>(definitions)}}},
          {"additionalProperties", map_schema<ContactSpec>(definitions)}};
}

}  // namespace conddp
