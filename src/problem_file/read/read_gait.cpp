#include <algorithm>
#include <cmath>
#include <numbers>
#include <span>

#include <fmt/format.h>

#include "base/text/spelling.hpp"
#include "problem_file/read/read_sections.hpp"
#include "problem_file/spec/enum_names.hpp"

namespace conddp {
namespace {

struct Role {
  std::string_view name;
  double start;
};
constexpr Role kQuadrupedWalk[] = {{"LF", 0.25}, {"RF", 0.75}, {"LH", 0}, {"RH", 0.5}};
constexpr Role kTrot[] = {{"LF", 0.5}, {"RF", 0}, {"LH", 0}, {"RH", 0.5}};
constexpr Role kPace[] = {{"LF", 0.5}, {"RF", 0}, {"LH", 0.5}, {"RH", 0}};
constexpr Role kBound[] = {{"LF", 0}, {"RF", 0}, {"LH", 0.5}, {"RH", 0.5}};
constexpr Role kBipedWalk[] = {{"L", 0}, {"R", 0.5}};

/// Possible sets of roles of a gait type; empty if its feet move together.
std::vector<std::span<const Role>> role_sets(GaitType type) {
  switch (type) {
    case GaitType::walk:
      return {kQuadrupedWalk, kBipedWalk};
    case GaitType::trot:
      return {kTrot};
    case GaitType::pace:
      return {kPace};
    case GaitType::bound:
      return {kBound};
    case GaitType::stand:
    case GaitType::jump:
      break;
  }
  return {};
}

double usual_duty(GaitType type, std::size_t feet) {
  if (type == GaitType::walk) return feet == 2 ? 0.6 : 0.75;
  return 0.5;
}

const ContactSpec* find_contact(const std::vector<ContactSpec>& contacts, std::string_view name) {
  const auto found = std::find_if(contacts.begin(), contacts.end(),
                                  [&](const ContactSpec& c) { return c.name.value == name; });
  return found == contacts.end() ? nullptr : &*found;
}

/// "write 'feet: {LF: ..., RF: ...}' or 'feet: ...'".
std::string feet_hint(const std::vector<std::span<const Role>>& sets) {
  std::string hint;
  for (const auto& roles : sets) {
    std::string text;
    for (const Role& role : roles)
      text += fmt::format("{}{}: ...", text.empty() ? "" : ", ", role.name);
    hint += fmt::format("{}'feet: {{{}}}'", hint.empty() ? "write " : " or ", text);
  }
  return hint;
}

/// True if all roles are names of contacts.
bool are_contacts(std::span<const Role> roles, const std::vector<ContactSpec>& contacts) {
  return std::all_of(roles.begin(), roles.end(), [&](const Role& role) {
    return find_contact(contacts, role.name) != nullptr;
  });
}

/// Default feet: the contacts with the names of the roles.
void find_feet(const YamlReader& reader, const std::vector<ContactSpec>& contacts, GaitSpec& gait) {
  const auto sets = role_sets(gait.type.value);
  if (sets.empty()) {
    for (const ContactSpec& contact : contacts)
      gait.feet.push_back({contact.name.value, {contact.name.value, gait.place}});
    if (contacts.empty()) reader.error("a gait needs feet, and the file has no 'contacts'");
    return;
  }
  const auto roles = std::find_if(sets.begin(), sets.end(),
                                  [&](const auto& set) { return are_contacts(set, contacts); });
  if (roles == sets.end())
    return reader.error("it is not clear which contacts are the feet: none have the feet's names",
                        feet_hint(sets));
  for (const Role& role : *roles) {
    const std::string name(role.name);
    gait.feet.push_back({name, {name, gait.place}, role.start});
  }
}

void check_contact(const YamlReader& reader, const std::vector<ContactSpec>& contacts,
                   const GaitSpec& gait, const Name& name) {
  std::vector<std::string> known;
  for (const ContactSpec& contact : contacts) known.push_back(contact.name.value);
  if (find_contact(contacts, name.value) == nullptr)
    reader.error(
        fmt::format("unknown contact '{}'", name.value),
        known.empty() ? "the file has no 'contacts'" : name_hint(name.value, known, "contacts"));
  for (const FootSpec& foot : gait.feet)
    if (foot.contact.value == name.value)
      reader.error(fmt::format("the contact '{}' is the foot '{}' already", name.value, foot.role));
}

/// Cycle start of a foot by its role, 0 without roles. A role that the gait type does not have is
/// reported.
double usual_start(const Name& role, std::span<const Role> roles, GaitType type, Diagnostics& out) {
  const auto known =
      std::find_if(roles.begin(), roles.end(), [&](const Role& r) { return r.name == role.value; });
  if (known != roles.end()) return known->start;
  if (roles.empty()) return 0;
  std::vector<std::string> names;
  for (const Role& r : roles) names.emplace_back(r.name);
  out.error(role.place, fmt::format("a {} has no foot '{}'", word_of(kGaitWords, type), role.value),
            name_hint(role.value, names, "feet"), names);
  return 0;
}

/// True if the file gives the cycle start of every foot.
bool starts_all(const std::optional<YamlReader>& starts, const YamlReader& feet) {
  return starts && std::ranges::all_of(feet.node().entries, [&](const YamlNode::Entry& foot) {
           return starts->node().find(foot.key) != nullptr;
         });
}

/// Reads the feet. `starts`: cycle starts of the file, if given. If they are complete, the gait
/// accepts any feet.
void read_feet(const YamlReader& reader, const std::vector<ContactSpec>& contacts,
               const std::optional<YamlReader>& starts, GaitSpec& gait) {
  const auto entries = reader.named_entries();
  if (!entries) return;
  const GaitType type = gait.type.value;
  auto sets = role_sets(type);
  if (!entries->empty() && starts_all(starts, reader)) sets.clear();
  const auto fitting = std::find_if(sets.begin(), sets.end(),
                                    [&](const auto& set) { return set.size() == entries->size(); });
  const std::span<const Role> roles = fitting == sets.end() ? std::span<const Role>() : *fitting;
  for (const auto& [role, value] : *entries) {
    const auto name = value.name();
    if (!name) continue;
    check_contact(value, contacts, gait, *name);
    const double start = usual_start(role, roles, type, reader.diagnostics());
    gait.feet.push_back({role.value, *name, start});
  }
  if (!sets.empty() && roles.empty())
    reader.error(
        fmt::format("a {} of {} feet is not known", word_of(kGaitWords, type), entries->size()),
        feet_hint(sets) + ", or say of each foot when its cycle starts: 'starts: {...}'");
  else if (entries->empty())
    reader.error("there is no foot");
}

void read_starts(const YamlReader& reader, GaitSpec& gait) {
  static const NumberRange kShare{0, 1, false, true, "a share of the cycle from 0 to 1 (excluded)"};
  for (const auto& [role, start] : read_named_numbers(reader, kShare)) {
    const auto foot = std::ranges::find(gait.feet, role.value, &FootSpec::role);
    if (foot != gait.feet.end()) {
      foot->start = start;
      continue;
    }
    std::vector<std::string> names;
    for (const FootSpec& f : gait.feet) names.push_back(f.role);
    reader.diagnostics().error(role.place, fmt::format("the gait has no foot '{}'", role.value),
                               name_hint(role.value, names, "feet"), names);
  }
}

void read_step(const YamlReader& reader, GaitSpec& gait) {
  static const NumberRange kTurn{-std::numbers::pi, std::numbers::pi, false, false,
                                 "an angle from -π to π"};
  YamlMap map(reader);
  map.number("length", gait.step_length, kNotNegative);
  map.number("height", gait.step_height, kNotNegative);
  map.number("direction", gait.direction);
  map.number("turn", gait.turn, kTurn);
}

bool read_located(YamlMap& map, std::string_view key, Located<double>& value,
                  const NumberRange& range) {
  value.place = map.reader().place();
  const auto reader = map.find(key);
  if (!reader) return false;
  value = {reader->number(range).value_or(value.value), reader->place()};
  return true;
}

/// Reads the standing time before and after the gait.
void read_stand(YamlMap& map, GaitSpec& gait) {
  gait.begin.place = gait.end.place = gait.place;
  const auto r = map.find("stand");
  if (!r) return;
  YamlMap stand(*r);
  read_located(stand, "begin", gait.begin, kNotNegative);
  read_located(stand, "end", gait.end, kNotNegative);
}

void reject_steps(YamlMap& map) {
  for (const char* key :
       {"starts", "cycles", "period", "duty", "step", "commands", "impulses", "weight"})
    if (const auto r = map.find(key))
      r->error(fmt::format("standing feet make no steps: the gait 'stand' has no '{}'", key));
}

void read_steps(YamlMap& map, GaitSpec& gait) {
  if (const auto r = map.find("starts")) read_starts(*r, gait);
  map.integer("cycles", gait.cycles, 1, kMostGaitCycles);
  if (map.require("period")) read_located(map, "period", gait.period, kPositive);
  gait.duty.value = usual_duty(gait.type.value, gait.feet.size());
  static const NumberRange kShare{0, 1, true, false, "a share of the cycle from 0 (excluded) to 1"};
  read_located(map, "duty", gait.duty, kShare);
  if (const auto r = map.find("step")) read_step(*r, gait);
  gait.commands = read_commands(map);
  static constexpr Choice<bool> kWords[] = {{"true", true}, {"false", false}};
  map.choice("impulses", gait.impulses, kWords, "value of 'impulses'");
  map.number("weight", gait.weight, kPositive);
}

/// Reads a planar velocity, m/s.
void read_velocity(const YamlReader& reader, GaitCommand& command) {
  constexpr double kFastest = 1e3;
  const auto velocity = read_vector3(reader, "[forward, left, 0] in m/s");
  if (!velocity) return;
  if (std::max(std::abs(velocity->x), std::abs(velocity->y)) > kFastest)
    return reader.error(
        fmt::format("a command leads with at most {:g} m/s in each direction", kFastest));
  if (velocity->z != 0)
    return reader.error("a command leads in the plane: its third velocity is 0",
                        "write '[forward, left, 0]'");
  command.x = velocity->x;
  command.y = velocity->y;
}

GaitCommand read_command(const YamlReader& reader) {
  GaitCommand command{.place = reader.place()};
  YamlMap map(reader, "write '{at: 1, velocity: [0.3, 0, 0], turn: 0.2}'");
  if (!map.valid()) return command;
  if (const auto r = map.require("at"))
    command.at = {r->number(kNotNegative).value_or(0), r->place()};
  if (const auto r = map.find("velocity")) read_velocity(*r, command);
  static const NumberRange kTurn{-1e3, 1e3, false, false, "a number from -1000 to 1000"};
  map.number("turn", command.turn, kTurn);
  return command;
}

}  // namespace

std::vector<GaitCommand> read_commands(YamlMap& map) {
  std::vector<GaitCommand> commands;
  for_each_item(map, "commands", [&](const YamlReader& item) {
    commands.push_back(read_command(item));
    const std::size_t count = commands.size();
    if (count > 1 && !(commands[count - 2].at.value < commands.back().at.value))
      item.diagnostics().error(commands.back().at.place,
                               "commands stand in the order of their times");
  });
  return commands;
}

GaitSpec read_gait(const YamlReader& reader, const std::vector<ContactSpec>& contacts) {
  GaitSpec gait{.place = reader.place()};
  YamlMap map(reader);
  const auto type = map.require("type");
  const auto chosen = type ? type->choice(kGaitWords, "gait") : std::nullopt;
  if (!chosen) {
    map.ignore_others();
    return gait;
  }
  gait.type = {*chosen, type->place()};
  if (const auto r = map.find("feet"))
    read_feet(*r, contacts, map.find("starts"), gait);
  else
    find_feet(reader, contacts, gait);
  if (map.require("dt")) read_located(map, "dt", gait.dt, kPositive);
  read_stand(map, gait);
  if (*chosen == GaitType::stand)
    reject_steps(map);
  else
    read_steps(map, gait);
  return gait;
}

}  // namespace conddp
