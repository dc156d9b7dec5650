#include <algorithm>
#include <limits>
#include <numeric>
#include <string>
#include <unordered_set>

#include <fmt/format.h>

#include "problem_file/model/expression_source.hpp"
#include "problem_file/model/phase_grid.hpp"
#include "problem_file/read/read_sections.hpp"

namespace conddp {

static void describe(Keys& keys, RefineSpec& refine) {
  static const NumberRange kRatio{0, 1, true, true, "a number between 0 and 1"};
  keys.about({.title = "Finer grid at the ends of a phase",
              .examples = R"([{"first": 3}, {"first": 2, "last": 2, "ratio": 0.6}])"});
  keys({"first",
        "How many first steps are shorter: each is ratio times as long as the one after it"},
       refine.first, IntegerForm{0, kMaxKnots});
  keys(
      {"last", "How many last steps are shorter: each is ratio times as long as the one before it"},
      refine.last, IntegerForm{0, kMaxKnots});
  keys({"ratio", "Of neighbouring steps, without unit"}, refine.ratio, NumberForm{kRatio});
}

static void describe(Keys& keys, FreeDurationSpec& free) {
  keys.about({.title = "Duration that is chosen", .examples = R"([{"lower": 0.5, "upper": 3}])"});
  keys({.name = "lower",
        .says = "How long the phase lasts at least, s; by default a tenth of what is written",
        .fallback = "none"},
       free.lower, NumberForm{kPositive});
  keys({.name = "upper",
        .says = "How long it lasts at most, s; by default ten times what is written",
        .fallback = "none"},
       free.upper, NumberForm{kPositive});
}

namespace {

/// `all`, `none`, a name or a list of names of tangent coordinates, which may contain a `*`.
struct CoordinatesForm {
  bool read(const YamlReader& reader, ComponentsSpec& coordinates) const {
    coordinates = {.place = reader.place()};
    const std::string_view word = reader.is_scalar() ? std::string_view(reader.node().text) : "";
    if (word == "all") return coordinates.scalar = 1, true;
    const bool none = word == "none";
    const auto names = none ? std::vector<Name>() : reader.name_or_names();
    if (!names) return false;
    coordinates.form = ComponentsSpec::Form::kMap;
    for (const Name& name : *names) coordinates.map.emplace_back(name, 1.0);
    return true;
  }
  std::optional<OrderedJson> expand(const ComponentsSpec& coordinates) const {
    if (coordinates.form != ComponentsSpec::Form::kMap) return "all";
    if (coordinates.map.empty()) return "none";
    OrderedJson names = OrderedJson::array();
    for (const auto& entry : coordinates.map) names.push_back(entry.first.value);
    return names;
  }
  OrderedJson schema() const {
    OrderedJson names = NamesForm().schema();
    names["minItems"] = 1;
    return {{"anyOf", {NameForm().schema(), std::move(names)}}};
  }
};

/// States that change in a jump, with their new values.
struct JumpForm {
  bool read(const YamlReader& reader, JumpSpec& jump) const {
    const auto entries = reader.named_entries("write '{v: -0.8*v}'");
    if (!entries) return false;
    if (entries->empty()) reader.error("no state jumps here", "write '{v: -0.8*v}'");
    for (const auto& [name, value] : *entries)
      if (auto text = read_expression(value)) jump.states.emplace_back(name, *text);
    return true;
  }
  std::optional<OrderedJson> expand(const JumpSpec& jump) const {
    OrderedJson json = OrderedJson::object();
    for (const auto& [name, expression] : jump.states) json[name.value] = expression.text;
    return json;
  }
  OrderedJson schema() const {
    return {{"type", "object"},
            {"minProperties", 1},
            {"additionalProperties", {{"type", {"string", "number"}}}}};
  }
};

/// Reports keys that do not belong to this kind of phase.
void reject(YamlMap* map, std::initializer_list<const char*> keys, std::string_view message,
            const char* hint) {
  if (map == nullptr) return;
  for (const char* key : keys)
    if (const auto r = map->find(key)) r->error(fmt::format(fmt::runtime(message), key), hint);
}

void describe_choice(Keys& keys, PhaseSpec& phase) {
  ChoiceSpec& choice = *phase.choice;
  keys({.name = "choose",
        .says = "Makes the first phase the choice of the initial state: one knot that takes no "
                "time, whose controls move these components of 'initial_state'; all, none "
                "(durations alone are chosen), or names, which may have a *",
        .examples = R"(["all", ["theta", "v/*"]])",
        .fallback = "none"},
       choice.coordinates, CoordinatesForm{});
  keys({"lower", "Of a choice: lower bounds of the displacement from 'initial_state'; null: none"},
       choice.lower, BoundsForm{});
  keys({"upper", "Of a choice: upper bounds of the displacement from 'initial_state'; null: none"},
       choice.upper, BoundsForm{});
  reject(keys.reading(),
         {"knots", "dt", "duration", "free_duration", "refine", "contacts", "restitution",
          "weights", "system"},
         "the choice of the initial state takes no time: it has no '{}'",
         "write '- {choose: all}', and the phase after it as another entry");
}

void describe_jump(Keys& keys, PhaseSpec& phase) {
  keys({.name = "jump",
        .says = "Makes the phase a jump: one knot that takes no time, after which these states are "
                "what their expressions say, in their units; the others stay",
        .examples = R"([{"v": "-0.8*v"}])",
        .fallback = "none"},
       *phase.jump, JumpForm{});
  reject(
      keys.reading(),
      {"knots", "dt", "duration", "free_duration", "refine", "contacts", "restitution", "system"},
      "a jump takes no time: it has no '{}'",
      "write '- {jump: {v: -0.8*v}}', and the phase after it as another entry");
}

void describe_impulse(Keys& keys, PhaseSpec& phase) {
  static const NumberRange kRestitution{0, 1, false, false, "a number from 0 to 1"};
  keys({"impulse",
        "Makes the phase an impulse: one knot that takes no time, at which these contacts stop "
        "(name those that stand already, too)"},
       phase.contacts, ContactNamesForm{});
  keys({"restitution",
        "Of an impulse: share of the contacts' velocity that is thrown back, without unit"},
       phase.restitution, NumberForm{kRestitution});
  reject(keys.reading(),
         {"knots", "dt", "duration", "free_duration", "refine", "contacts", "system"},
         "an impulse takes no time: it has no '{}'",
         "write '- {impulse: [contacts]}', and the phase after it as another entry");
}

void check_refine(const YamlReader& reader, PhaseSpec& phase) {
  RefineSpec& refine = *phase.refine;
  if (refine.first + refine.last >= phase.knots.value) {
    reader.error(
        fmt::format("'first' and 'last' leave none of the {} knots as it is", phase.knots.value));
    refine.first = refine.last = 0;
  } else if (refine.first + refine.last == 0) {
    reader.error("nothing is refined", "give 'first', 'last' or both");
  }
}

/// By default a tenth and ten times the duration in the file.
FreeDurationSpec usual_bounds(double written) {
  constexpr double kMost = 10;
  return {.lower = std::max(written / kMost, std::numeric_limits<double>::min()),
          .upper = written * kMost};
}

void check_free_duration(const YamlReader& reader, double written, const FreeDurationSpec& free) {
  if (free.lower > free.upper)
    reader.error(fmt::format("'lower' is {:.6g}, above 'upper', {:.6g}", free.lower, free.upper));
  else if (reader.is_map() && written > 0 && !(free.lower <= written && written <= free.upper))
    reader.error(
        fmt::format("the phase lasts {:.6g} s as it is written, which does not lie between "
                    "{:.6g} and {:.6g}",
                    written, free.lower, free.upper));
}

/// The duration of a phase with knots, as its step or in total.
void describe_duration(Keys& keys, PhaseSpec& phase) {
  std::optional<double> duration;
  keys({.name = "dt",
        .says = "Time step, that between the refined ends of a phase, s",
        .fallback = "none"},
       phase.dt, NumberForm{kPositive});
  keys({"duration", "Duration of the phase instead of dt, s"}, duration, NumberForm{kPositive});
  keys({"refine", "Shorter steps where the phase begins or ends, as at switches of contacts"},
       phase.refine, MapForm{});
  if (const auto refine = keys.found("refine"); refine && phase.refine)
    check_refine(*refine, phase);
  if (duration) {
    const std::vector<double> steps = relative_steps(phase);
    phase.dt = *duration / std::accumulate(steps.begin(), steps.end(), 0.0);
  }
  const auto free = keys.found("free_duration");
  if (free) phase.free_duration = usual_bounds(phase_duration(phase));
  keys({"free_duration",
        "Lets the solver choose how long the phase lasts, in the first phase, a choice; 'dt' or "
        "'duration' is where it begins"},
       phase.free_duration, MapForm{"write '{lower: 0.5, upper: 2}', in s"});
  if (free) check_free_duration(*free, phase_duration(phase), *phase.free_duration);
  if (YamlMap* map = keys.reading()) map->exclusive({"dt", "duration"});
  if (!keys.found("duration") && !keys.found("dt"))
    keys.error("a phase needs 'dt', the time step in s, or 'duration'");
}

/// The keys of a phase that takes time.
void describe_knots(Keys& keys, PhaseSpec& phase, bool with_contacts) {
  keys({"system", "Of 'systems' the one that moves"}, phase.system, NameForm{});
  YamlMap* map = keys.reading();
  if (map != nullptr && map->require("knots")) phase.knots.value = 1;
  keys({.name = "knots", .says = "Number of time steps", .fallback = "none"}, phase.knots,
       IntegerForm{1, kMaxKnots});
  describe_duration(keys, phase);
  keys({.name = "contacts",
        .says = "Contacts that are held; none by default",
        .omitted = !with_contacts},
       phase.contacts, ContactNamesForm{});
  reject(map, {"lower", "upper"}, "'{}' belongs to the choice of the initial state",
         "write '- {choose: all, lower: -1, upper: 1}'");
  reject(map, {"restitution"}, "'{}' belongs to impulses",
         "write '- {impulse: [contacts], restitution: 0}'");
}

/// Makes the phase an instant if its keys say so.
void read_instant(YamlMap& map, PhaseSpec& phase) {
  map.exclusive({"impulse", "choose"});
  map.exclusive({"impulse", "jump"});
  map.exclusive({"choose", "jump"});
  const auto impulse = map.find("impulse"), choose = map.find("choose"), jump = map.find("jump");
  if (impulse) {
    phase.restitution = 0;
    phase.knots = {1, impulse->place()};
  } else if (choose) {
    phase.choice.emplace();
    phase.knots = {1, choose->place()};
  } else if (jump) {
    phase.jump.emplace().place = jump->place();
    phase.knots = {1, jump->place()};
  }
}

constexpr std::string_view kKindsOfPhases = R"("oneOf": [
  {"required": ["knots", "dt"], "not": {"anyOf": [
    {"required": ["restitution"]}, {"required": ["choose"]}, {"required": ["lower"]},
    {"required": ["upper"]}]}},
  {"required": ["knots", "duration"], "not": {"anyOf": [
    {"required": ["restitution"]}, {"required": ["choose"]}, {"required": ["lower"]},
    {"required": ["upper"]}]}},
  {"required": ["jump"], "not": {"anyOf": [
    {"required": ["system"]}, {"required": ["knots"]}, {"required": ["dt"]},
    {"required": ["duration"]}, {"required": ["free_duration"]}, {"required": ["refine"]},
    {"required": ["contacts"]}, {"required": ["impulse"]}, {"required": ["restitution"]},
    {"required": ["choose"]}, {"required": ["lower"]}, {"required": ["upper"]}]}},
  {"required": ["impulse"], "not": {"anyOf": [
    {"required": ["system"]}, {"required": ["refine"]}, {"required": ["free_duration"]},
    {"required": ["knots"]}, {"required": ["dt"]}, {"required": ["duration"]},
    {"required": ["contacts"]}, {"required": ["choose"]}, {"required": ["lower"]},
    {"required": ["upper"]}]}},
  {"required": ["choose"], "not": {"anyOf": [
    {"required": ["system"]}, {"required": ["knots"]}, {"required": ["free_duration"]},
    {"required": ["contacts"]}, {"required": ["weights"]}, {"required": ["restitution"]}]}}
])";

}  // namespace

static void describe(Keys& keys, PhaseSpec& phase, bool with_contacts) {
  keys.about({.definition = "phase",
              .title = "Phase",
              .says = "A run of knots with the same structure, or an impulse or a jump between two "
                      "of them",
              .examples = R"([{"name": "start", "choose": "all"},
                              {"name": "swing", "knots": 100, "dt": 0.01,
                               "contacts": ["LF", "RH"]},
                              {"name": "landing", "impulse": ["LF", "RF"]}])",
              .rules = kKindsOfPhases});
  keys({.name = "name", .says = "Unique; phase_1, phase_2, ... by default", .fallback = "none"},
       phase.name, NameForm{});
  if (YamlMap* map = keys.reading()) read_instant(*map, phase);
  const bool all = keys.documents();
  if (all) {
    phase.choice.emplace();
    phase.jump.emplace();
    phase.restitution = 0;
  }
  if (all || !phase.takes_no_time()) describe_knots(keys, phase, with_contacts);
  if (phase.jump) describe_jump(keys, phase);
  if (phase.restitution) describe_impulse(keys, phase);
  if (phase.choice) describe_choice(keys, phase);
  if (all || !phase.choice)
    keys({"weights", "Weights that costs have in this phase instead of their own"}, phase.weights,
         NamedNumbersForm{kNotNegative});
}

namespace {

/// Only the first phase may choose the initial state; it takes the contacts of the next phase.
void check_choices(std::vector<PhaseSpec>& phases, bool before_gait, Diagnostics& out) {
  for (std::size_t i = 1; i < phases.size(); ++i)
    if (phases[i].choice)
      out.error(phases[i].knots.place, "only the first phase can choose the initial state");
  if (phases.empty() || !phases[0].choice || before_gait) return;
  if (phases.size() == 1)
    out.error(phases[0].knots.place, "no phase follows that takes time");
  else
    phases[0].contacts = phases[1].restitution ? ContactNames{} : phases[1].contacts;
}

}  // namespace

bool PhasesForm::read(const YamlReader& reader, std::vector<PhaseSpec>& phases) const {
  const auto items = reader.items("write '[{knots: 100, dt: 0.01}]'");
  if (!items) return false;
  if (items->empty()) reader.error("there is no phase", "write '- {knots: 100, dt: 0.01}'");
  long long knots = 0;
  std::unordered_set<std::string> names;
  for (std::size_t i = 0; i < items->size(); ++i) {
    PhaseSpec& phase = phases.emplace_back();
    phase.name = {fmt::format("phase_{}", i + 1), (*items)[i].place()};
    GroupValue([&](Keys& keys) { describe(keys, phase, with_contacts); }).read((*items)[i]);
    knots += phase.knots.value;
    if (!names.insert(phase.name.value).second)
      reader.diagnostics().error(phase.name.place,
                                 fmt::format("two phases have the name '{}'", phase.name.value));
  }
  check_choices(phases, before_gait, reader.diagnostics());
  if (knots > kMaxKnots)
    reader.error(fmt::format("the phases have more than {} knots together", kMaxKnots));
  return true;
}

std::optional<OrderedJson> PhasesForm::expand(const std::vector<PhaseSpec>& phases) const {
  OrderedJson json = OrderedJson::array();
  for (PhaseSpec phase : phases) {
    KeyWriter keys;
    describe(keys, phase, with_contacts);
    json.push_back(std::move(keys.json));
  }
  return json;
}

OrderedJson PhasesForm::schema(const std::vector<PhaseSpec>& /*names the type*/,
                               SchemaDefinitions& definitions) const {
  PhaseSpec phase;
  const GroupValue keys([&](Keys& own) { describe(own, phase, with_contacts); });
  return {{"type", "array"}, {"minItems", 1}, {"items", keys.schema(definitions)}};
}

}  // namespace conddp
