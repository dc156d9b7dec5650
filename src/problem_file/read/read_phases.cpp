#include <algorithm>
#include <limits>
#include <numeric>
#include <string>
#include <unordered_set>

#include <fmt/format.h>

#include "problem_file/read/read_sections.hpp"
#include "problem_file/spec/expression_source.hpp"
#include "problem_file/spec/phase_grid.hpp"

namespace conddp {
namespace {

void read_impulse(YamlMap& map, const YamlReader& impulse, PhaseSpec& phase) {
  phase.contacts = read_contact_names(impulse);
  phase.knots = {1, impulse.place()};
  phase.restitution = 0;
  static const NumberRange kRestitution{0, 1, false, false, "a number from 0 to 1"};
  map.number("restitution", *phase.restitution, kRestitution);
  for (const char* key :
       {"knots", "dt", "duration", "free_duration", "refine", "contacts", "system"})
    if (const auto r = map.find(key))
      r->error(fmt::format("an impulse takes no time: it has no '{}'", key),
               "write '- {impulse: [contacts]}', and the phase after it as another entry");
}

/// `all`, `none`, a name or a list of names of tangent coordinates, which may contain a `*`.
ComponentsSpec read_coordinates(const YamlReader& reader) {
  ComponentsSpec coordinates{.place = reader.place()};
  const std::string_view word = reader.is_scalar() ? std::string_view(reader.node().text) : "";
  if (word == "all") {
    coordinates.scalar = 1;
  } else if (word == "none") {
    coordinates.form = ComponentsSpec::Form::kMap;
  } else if (const auto names = reader.name_or_names()) {
    coordinates.form = ComponentsSpec::Form::kMap;
    for (const Name& name : *names) coordinates.map.emplace_back(name, 1.0);
  }
  return coordinates;
}

void read_choice(YamlMap& map, const YamlReader& choose, PhaseSpec& phase) {
  phase.knots = {1, choose.place()};
  ChoiceSpec choice{.coordinates = read_coordinates(choose), .lower = {}, .upper = {}};
  if (const auto r = map.find("lower")) choice.lower = read_component_bounds(*r);
  if (const auto r = map.find("upper")) choice.upper = read_component_bounds(*r);
  for (const char* key : {"knots", "dt", "duration", "free_duration", "refine", "contacts",
                          "restitution", "weights", "system"})
    if (const auto r = map.find(key))
      r->error(fmt::format("the choice of the initial state takes no time: it has no '{}'", key),
               "write '- {choose: all}', and the phase after it as another entry");
  phase.choice = std::move(choice);
}

/// Reads the states that change in a jump, with their new values.
void read_jump(YamlMap& map, const YamlReader& jump, PhaseSpec& phase) {
  phase.knots = {1, jump.place()};
  phase.jump = JumpSpec{.place = jump.place(), .states = {}};
  const auto entries = jump.named_entries("write '{v: -0.8*v}'");
  if (entries && entries->empty()) jump.error("no state jumps here", "write '{v: -0.8*v}'");
  if (entries)
    for (const auto& [name, value] : *entries)
      if (auto text = read_expression(value)) phase.jump->states.emplace_back(name, *text);
  for (const char* key :
       {"knots", "dt", "duration", "free_duration", "refine", "contacts", "restitution", "system"})
    if (const auto r = map.find(key))
      r->error(fmt::format("a jump takes no time: it has no '{}'", key),
               "write '- {jump: {v: -0.8*v}}', and the phase after it as another entry");
}

RefineSpec read_refine(const YamlReader& reader, int knots) {
  RefineSpec refine;
  YamlMap map(reader);
  if (!map.valid()) return refine;
  static const NumberRange kRatio{0, 1, true, true, "a number between 0 and 1"};
  map.integer("first", refine.first, 0, kMaxKnots);
  map.integer("last", refine.last, 0, kMaxKnots);
  map.number("ratio", refine.ratio, kRatio);
  if (refine.first + refine.last >= knots) {
    reader.error(fmt::format("'first' and 'last' leave none of the {} knots as it is", knots));
    refine.first = refine.last = 0;
  } else if (refine.first + refine.last == 0) {
    reader.error("nothing is refined", "give 'first', 'last' or both");
  }
  return refine;
}

/// Reads the bounds on a free duration; by default a tenth and ten times the duration in the file.
FreeDurationSpec read_free_duration(const YamlReader& reader, double written) {
  constexpr double kMost = 10;
  FreeDurationSpec free{reader.place(),
                        std::max(written / kMost, std::numeric_limits<double>::min()),
                        written * kMost};
  YamlMap map(reader, "write '{lower: 0.5, upper: 2}', in s");
  map.number("lower", free.lower, kPositive);
  map.number("upper", free.upper, kPositive);
  if (free.lower > free.upper)
    reader.error(fmt::format("'lower' is {:.6g}, above 'upper', {:.6g}", free.lower, free.upper));
  else if (map.valid() && written > 0 && !(free.lower <= written && written <= free.upper))
    reader.error(
        fmt::format("the phase lasts {:.6g} s as it is written, which does not lie between "
                    "{:.6g} and {:.6g}",
                    written, free.lower, free.upper));
  return free;
}

void reject_keys_of_instants(YamlMap& map) {
  for (const char* key : {"lower", "upper"})
    if (const auto r = map.find(key))
      r->error(fmt::format("'{}' belongs to the choice of the initial state", key),
               "write '- {choose: all, lower: -1, upper: 1}'");
  if (const auto r = map.find("restitution"))
    r->error("'restitution' belongs to impulses",
             "write '- {impulse: [contacts], restitution: 0}'");
}

/// Reads the duration of a phase with knots, as its step or in total.
void read_duration(YamlMap& map, PhaseSpec& phase) {
  map.exclusive({"dt", "duration"});
  double duration = 0;
  if (map.number("duration", duration, kPositive)) {
    const std::vector<double> steps = relative_steps(phase);
    phase.dt = duration / std::accumulate(steps.begin(), steps.end(), 0.0);
  }
  map.number("dt", phase.dt, kPositive);
  if (const auto r = map.find("free_duration"))
    phase.free_duration = read_free_duration(*r, phase_duration(phase));
  if (map.valid() && !map.find("duration") && !map.find("dt"))
    map.reader().error("a phase needs 'dt', the time step in s, or 'duration'");
}

PhaseSpec read_phase(const YamlReader& reader, std::size_t index) {
  PhaseSpec phase{.name = {fmt::format("phase_{}", index + 1), reader.place()}};
  YamlMap map(reader);
  map.name("name", phase.name);
  if (const auto r = map.find("weights")) phase.weights = read_named_numbers(*r, kNotNegative);
  map.exclusive({"impulse", "choose"});
  map.exclusive({"impulse", "jump"});
  map.exclusive({"choose", "jump"});
  if (const auto r = map.find("impulse")) {
    read_impulse(map, *r, phase);
    return phase;
  }
  if (const auto r = map.find("choose")) {
    read_choice(map, *r, phase);
    return phase;
  }
  if (const auto r = map.find("jump")) {
    read_jump(map, *r, phase);
    return phase;
  }
  reject_keys_of_instants(map);
  Name system;
  if (map.name("system", system)) phase.system = std::move(system);
  map.read("contacts", phase.contacts, read_contact_names);
  if (const auto r = map.require("knots"))
    phase.knots = {static_cast<int>(r->integer(1, kMaxKnots).value_or(1)), r->place()};
  if (const auto r = map.find("refine")) phase.refine = read_refine(*r, phase.knots.value);
  read_duration(map, phase);
  return phase;
}

/// Only the first phase may choose the initial state; it takes the contacts of the next phase.
void check_choices(std::vector<PhaseSpec>& phases, Diagnostics& out) {
  for (std::size_t i = 1; i < phases.size(); ++i)
    if (phases[i].choice)
      out.error(phases[i].knots.place, "only the first phase can choose the initial state");
  if (phases.empty() || !phases[0].choice) return;
  if (phases.size() == 1)
    out.error(phases[0].knots.place, "no phase follows that takes time");
  else
    phases[0].contacts = phases[1].restitution ? ContactNames{} : phases[1].contacts;
}

}  // namespace

std::vector<PhaseSpec> read_phases(const YamlReader& reader) {
  std::vector<PhaseSpec> phases;
  const auto items = reader.items("write '[{knots: 100, dt: 0.01}]'");
  if (!items) return phases;
  if (items->empty()) reader.error("there is no phase", "write '- {knots: 100, dt: 0.01}'");
  long long knots = 0;
  std::unordered_set<std::string> names;
  for (std::size_t i = 0; i < items->size(); ++i) {
    phases.push_back(read_phase((*items)[i], i));
    knots += phases.back().knots.value;
    const Name& name = phases.back().name;
    if (!names.insert(name.value).second)
      reader.diagnostics().error(name.place,
                                 fmt::format("two phases have the name '{}'", name.value));
  }
  check_choices(phases, reader.diagnostics());
  if (knots > kMaxKnots)
    reader.error(fmt::format("the phases have more than {} knots together", kMaxKnots));
  return phases;
}

}  // namespace conddp
