#include <algorithm>
#include <cmath>
#include <numbers>
#include <span>

#include <fmt/format.h>

#include "base/text/spelling.hpp"
#include "problem_file/model/enum_names.hpp"
#include "problem_file/read/read_sections.hpp"

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

/// Cycle starts that replace those of the type.
void set_starts(const NamedNumbers& starts, Diagnostics& out, GaitSpec& gait) {
  for (const auto& [role, start] : starts) {
    const auto foot = std::ranges::find(gait.feet, role.value, &FootSpec::role);
    if (foot != gait.feet.end()) {
      foot->start = start;
      continue;
    }
    std::vector<std::string> names;
    for (const FootSpec& f : gait.feet) names.push_back(f.role);
    out.error(role.place, fmt::format("the gait has no foot '{}'", role.value),
              name_hint(role.value, names, "feet"), names);
  }
}

void describe_step(Keys& keys, GaitSpec& gait) {
  static const NumberRange kTurn{-std::numbers::pi, std::numbers::pi, false, false,
                                 "an angle from -π to π"};
  keys.about({.title = "Step of a gait",
              .examples = R"([{"length": 0.15, "height": 0.06, "turn": 0.2}])"});
  keys({"length", "Way of a cycle, the mean length of a foot's steps, m"}, gait.step_length,
       NumberForm{kNotNegative});
  keys({"height", "Height of the swings, m"}, gait.step_height, NumberForm{kNotNegative});
  keys({"direction", "Of the way, from where the base points to the left, rad"}, gait.direction,
       NumberForm{});
  keys({"turn", "Turn of a cycle, rad"}, gait.turn, NumberForm{kTurn});
}

void describe_stand(Keys& keys, GaitSpec& gait) {
  keys.about(
      {.title = "Standing before and after a gait", .examples = R"([{"begin": 0.2, "end": 0.4}])"});
  if (YamlMap* map = keys.reading()) gait.begin.place = gait.end.place = map->reader().place();
  keys({"begin", "Before the first foot lifts, s"}, gait.begin, NumberForm{kNotNegative});
  keys({"end", "After the last touch-down, s; one step at least where feet swing"}, gait.end,
       NumberForm{kNotNegative});
}

/// Reads a planar velocity, m/s.
void read_velocity(const YamlReader& reader, GaitCommand& command) {
  constexpr double kFastest = 1e3;
  Vector3<double> velocity;
  if (!VectorForm{"[forward, left, 0] in m/s"}.read(reader, velocity)) return;
  if (std::max(std::abs(velocity.x), std::abs(velocity.y)) > kFastest)
    return reader.error(
        fmt::format("a command leads with at most {:g} m/s in each direction", kFastest));
  if (velocity.z != 0)
    return reader.error("a command leads in the plane: its third velocity is 0",
                        "write '[forward, left, 0]'");
  command.x = velocity.x;
  command.y = velocity.y;
}

/// The keys of the feet and of their steps, which standing feet do not have.
void describe_steps(Keys& keys, GaitSpec& gait) {
  static const NumberRange kStart{0, 1, false, true, "a share of the cycle from 0 to 1 (excluded)"};
  static const NumberRange kDuty{0, 1, true, false, "a share of the cycle from 0 (excluded) to 1"};
  NamedNumbers starts;
  keys({.name = "starts",
        .says = "Shares of the cycle, without unit, after which feet lift instead of those of the "
                "type, by foot",
        .examples = R"([{"LH": 0, "LF": 0.2, "RH": 0.5, "RF": 0.7}])"},
       starts, NamedNumbersForm{kStart, true});
  keys({"cycles", "How often each foot swings"}, gait.cycles, IntegerForm{1, kMostGaitCycles});
  if (YamlMap* map = keys.reading()) {
    set_starts(starts, map->reader().diagnostics(), gait);
    map->require("period");
    gait.period.place = gait.duty.place = gait.place;
    gait.duty.value = usual_duty(gait.type.value, gait.feet.size());
  }
  keys({.name = "period",
        .says = "Duration of a cycle, s; a whole number of steps",
        .fallback = "none"},
       gait.period, NumberForm{kPositive});
  keys({.name = "duty",
        .says = "Share of the cycle that a foot stands, without unit; by default 0.5, of a walk "
                "0.75 (two feet: 0.6)",
        .fallback = "none"},
       gait.duty, NumberForm{kDuty});
  keys({.name = "step", .says = "How far the robot goes in a cycle", .fallback = "{}"},
       GroupValue([&](Keys& step) { describe_step(step, gait); }));
  keys({"commands",
        "Velocities of the way from times on, in place of length, direction and turn of the step"},
       gait.commands, CommandsForm{});
  keys({"impulses", "Whether each touch-down is an impulse"}, gait.impulses,
       FlagForm{"value of 'impulses'"});
  keys({"weight",
        "Weight of the costs on the swings, in the cost's unit per square of a length or angle"},
       gait.weight, NumberForm{kPositive});
}

void reject_steps(YamlMap& map) {
  for (const char* key :
       {"starts", "cycles", "period", "duty", "step", "commands", "impulses", "weight"})
    if (const auto r = map.find(key))
      r->error(fmt::format("standing feet make no steps: the gait 'stand' has no '{}'", key));
}

}  // namespace

static void describe(Keys& keys, FreeSharesSpec& shares) {
  static const NumberRange kShorter{0, 1, true, false, "a share from 0 (excluded) to 1"};
  static const NumberRange kLonger{1, 1e3, false, false, "a share from 1 to 1000"};
  keys.about(
      {.title = "Free durations of a gait", .examples = R"([{"lower": 0.6, "upper": 1.6}])"});
  keys({"lower", "Shortest duration of a phase, as a share, without unit"}, shares.lower,
       NumberForm{kShorter});
  keys({"upper", "Longest duration of a phase, as a share, without unit"}, shares.upper,
       NumberForm{kLonger});
}

static void describe(Keys& keys, GaitCommand& command) {
  static const NumberRange kTurn{-1e3, 1e3, false, false, "a number from -1000 to 1000"};
  keys.about(
      {.title = "Command", .examples = R"([{"at": 3, "velocity": [0.3, 0, 0], "turn": 0.2}])"});
  keys({.name = "at", .says = "From when on, s", .required = true, .examples = "[3]"}, command.at,
       NumberForm{kNotNegative});
  keys({.name = "velocity",
        .says = "Of the base, forward and to the left as it points, m/s; the third number is 0",
        .examples = "[[0.3, 0, 0]]",
        .fallback = "[0, 0, 0]"},
       CustomValue{[&](const YamlReader& reader) { read_velocity(reader, command); },
                   {},
                   R"({"type": "array", "minItems": 3, "maxItems": 3,
                       "items": {"type": "number", "minimum": -1000, "maximum": 1000}})"});
  keys({.name = "turn", .says = "To the left, rad/s", .examples = "[0.2]"}, command.turn,
       NumberForm{kTurn});
}

bool CommandsForm::read(const YamlReader& reader, std::vector<GaitCommand>& commands) const {
  const MapsForm maps{"write '{at: 1, velocity: [0.3, 0, 0], turn: 0.2}'"};
  if (!maps.read(reader, commands)) return false;
  for (std::size_t i = 1; i < commands.size(); ++i)
    if (!(commands[i - 1].at.value < commands[i].at.value))
      reader.diagnostics().error(commands[i].at.place,
                                 "commands stand in the order of their times");
  return true;
}

OrderedJson CommandsForm::schema(const std::vector<GaitCommand>& value,
                                 SchemaDefinitions& definitions) const {
  OrderedJson commands = {
      {"title", "Commands"},
      {"description", "Velocities that a gait is to have, in the order of their times"}};
  commands.update(MapsForm().schema(value, definitions));
  commands["default"] = OrderedJson::array();
  commands["examples"] = OrderedJson::parse(
      R"([[{"at": 0, "velocity": [0.3, 0, 0]}, {"at": 3, "velocity": [0.3, 0, 0], "turn": 0.2}]])");
  definitions["commands"] = std::move(commands);
  return {{"$ref", "#/definitions/commands"}};
}

static void describe(Keys& keys, GaitSpec& gait, const std::vector<ContactSpec>& contacts) {
  keys.about({.definition = "gait",
              .title = "Gait",
              .says = "Makes the phases, and a cost swing_<contact> on the swings of each foot; "
                      "conddp check --expand shows them",
              .examples = R"([{"type": "trot", "cycles": 2, "period": 0.48, "dt": 0.02,
                               "step": {"length": 0.15, "height": 0.06}}])"});
  YamlMap* map = keys.reading();
  const int errors = keys.errors();
  keys({.name = "type",
        .says = "Which feet swing together: a walk one after the other (four feet or two), a trot "
                "diagonal pairs, a pace those of a side, a bound those in front and behind, a jump "
                "all",
        .required = true},
       gait.type, WordForm{kGaitWords, "gait"});
  if (keys.errors() > errors) return map->ignore_others();
  keys({.name = "feet",
        .says = "Contacts of the feet: LF, RF, LH and RH, of a walk also L and R, of stand and "
                "jump any; by default the contacts of these names, and all of stand and jump",
        .examples = R"([{"LF": "front_left", "RF": "front_right", "LH": "hind_left",
                         "RH": "hind_right"}])"},
       CustomValue{[&](const YamlReader& reader) {
                     read_feet(reader, contacts, map->find("starts"), gait);
                   },
                   {},
                   R"({"type": "object", "minProperties": 1,
                       "additionalProperties": {"type": "string", "minLength": 1}})"});
  if (map != nullptr && !map->find("feet")) find_feet(map->reader(), contacts, gait);
  keys({.name = "dt", .says = "Time step, s", .required = true}, gait.dt, NumberForm{kPositive});
  gait.begin.place = gait.end.place = gait.place;
  keys({.name = "stand",
        .says = "How long all feet stand before and after; of the gait stand both together",
        .fallback = "{}"},
       GroupValue([&](Keys& stand) { describe_stand(stand, gait); }));
  keys(
      {"free_durations",
       "The solver chooses the duration of each phase, between these shares of its duration in the "
       "other keys"},
      gait.free_durations, MapForm{"write '{lower: 0.6, upper: 1.6}', or {}"});
  if (gait.free_durations && map != nullptr)
    gait.free_durations->place = keys.found("free_durations")->place();
  if (map != nullptr && gait.type.value == GaitType::stand)
    reject_steps(*map);
  else
    describe_steps(keys, gait);
}

bool GaitForm::read(const YamlReader& reader, GaitSpec& gait) const {
  gait.place = reader.place();
  GroupValue([&](Keys& keys) { describe(keys, gait, contacts); }).read(reader);
  return true;
}

OrderedJson GaitForm::schema(GaitSpec gait, SchemaDefinitions& definitions) const {
  return GroupValue([&](Keys& keys) { describe(keys, gait, contacts); }).schema(definitions);
}

}  // namespace conddp
