#include "problem_file/read/read_problem.hpp"

#include <algorithm>

#include <fmt/format.h>

#include "base/files/folder_name.hpp"
#include "base/files/sha256.hpp"
#include "base/files/source_text.hpp"
#include "base/text/spelling.hpp"
#include "problem_file/lower/rewriting.hpp"
#include "problem_file/lower/similar_names.hpp"
#include "problem_file/read/read_sections.hpp"
#include "problem_file/spec/enum_names.hpp"
#include "problem_file/yaml/canonical_definition.hpp"
#include "problem_file/yaml/yaml_source.hpp"

namespace conddp {

void describe(Keys& keys, Perturbation& perturbation) {
  static constexpr NumberRange kSpread{0, kLargestSpread, false, false, "a number from 0 to 1e6"};
  keys.about({.definition = "perturbation",
              .title = "One of many random instances",
              .says = "Moves initial state and first trajectory by random numbers, as conddp bench "
                      "--perturb does",
              .examples = R"([{"initial_state": 0.1, "seed": 5}])"});
  keys({"initial_state",
        "The initial state moves by a tangent vector with entries of up to this, each in its own "
        "unit; references that name it stay"},
       perturbation.initial_state, NumberForm{kSpread});
  keys({"guess",
        "Standard deviation of normal numbers that are added to states and controls of the first "
        "trajectory, each in its own unit"},
       perturbation.guess, NumberForm{kSpread});
  keys({"seed", "Which instance: the one of conddp bench with the same seed"}, perturbation.seed,
       IntegerForm{0, kLargestSeed});
  YamlMap* map = keys.reading();
  // An expanded file always has a seed.
  if (map != nullptr && !perturbation.any() && perturbation.seed != Perturbation{}.seed)
    map->reader().diagnostics().warning(map->find("seed")->place(),
                                        "the seed has no effect, as nothing is perturbed",
                                        "write 'perturbation: {initial_state: 0.1, seed: 2}'");
}

namespace {

/// Reads robots by name.
void read_robots(const YamlReader& reader, const std::filesystem::path& folder, ProblemSpec& spec) {
  const auto entries = reader.named_entries();
  if (!entries) return;
  for (const auto& [name, value] : *entries) {
    spec.robots.push_back(read_robot(value, folder));
    spec.robots.back().name = name;
    if (name.value.find_first_of("/,") != std::string::npos)
      reader.diagnostics().error(name.place, "a robot's name has no '/' and no ','");
  }
}

/// Reads systems by name. The problem's system is the file's first one, until phases are known.
void read_systems(const YamlReader& reader, const std::filesystem::path& folder,
                  ProblemSpec& spec) {
  const auto entries = reader.named_entries("write '{a: {states: ..., rate: ...}, b: {...}}'");
  if (!entries) return;
  for (const auto& [name, value] : *entries)
    spec.systems.push_back({name, read_system(value, {folder, spec.names})});
  if (entries->empty())
    reader.error("there is no system", "write '{a: {states: ..., rate: ...}, b: {...}}'");
  else
    spec.system = spec.systems.front().system;
}

void read_plant(YamlMap& map, const std::filesystem::path& folder, ProblemSpec& spec) {
  const auto robot = map.find("robot");
  const auto robots = map.find("robots");
  const auto system = map.find("system");
  const auto systems = map.find("systems");
  constexpr std::string_view kWays[] = {"robot", "robots", "system", "systems"};
  for (const std::string_view& one : kWays)
    for (const std::string_view* other = &one + 1; other != std::end(kWays); ++other)
      map.exclusive({one, *other});
  if (robot) spec.robots.push_back(read_robot(*robot, folder));
  if (robots) read_robots(*robots, folder, spec);
  if (system) spec.system = read_system(*system, {folder, spec.names});
  if (systems) read_systems(*systems, folder, spec);
  if (!robot && !robots && !system && !systems && map.valid())
    map.reader().error("the file defines nothing that moves: give 'robot', 'robots' or 'system'");
}

void read_gravity(YamlMap& map, ProblemSpec& spec) {
  const auto r = map.find("gravity");
  if (!r) return;
  spec.gravity = read_vector3(*r, "[x, y, z] in m/s²").value_or(spec.gravity);
  if (spec.system) r->error("a closed-form system has its gravity among its parameters");
}

void read_format(YamlMap& map) {
  const auto format = map.require("conddp");
  if (!format) return;
  const auto version = format->integer(1, 1'000'000);
  if (version && *version != kProblemFormat)
    format->error(fmt::format("the file has format {}, and this version reads format {}", *version,
                              kProblemFormat));
}

void read_name(const YamlReader& reader, Name& name) {
  name = reader.name().value_or(name);
  if (!names_folder(name.value)) reader.error(kFolderNameRule);
}

/// Reads the initial state, the integrator and the course of controls and running costs.
void read_motion(YamlMap& map, ProblemSpec& spec) {
  if (const auto r = map.require("initial_state"))
    if (auto state = read_state(*r)) spec.initial_state = std::move(*state);
  if (const auto r = map.find("integrator"))
    if (const auto integrator = r->choice(kIntegratorWords, "integrator"))
      spec.integrator = {*integrator, r->place()};
  if (const auto r = map.find("controls"))
    if (const auto course = r->choice(kControlCourseWords, "course of the controls"))
      spec.controls = {*course, r->place()};
  if (const auto r = map.find("running_costs"))
    if (const auto kind = r->choice(kRunningCostsWords, "kind of running costs"))
      spec.running_costs = {*kind, r->place()};
}

/// Reads a key for robots only; a missing key is skipped. `message`: reason why a closed-form
/// system does not support it.
template <class Read>
void read_of_robots(YamlMap& map, const ProblemSpec& spec, std::string_view key,
                    const char* message, Read read) {
  const auto reader = map.find(key);
  if (!reader) return;
  read(*reader);
  if (spec.system) reader->error(message);
}

/// Reads contacts and collision shapes.
void read_surroundings(YamlMap& map, ProblemSpec& spec) {
  read_of_robots(map, spec, "contacts",
                 "a closed-form system has no frames that could touch the world",
                 [&](const YamlReader& r) { ContactsForm().read(r, spec.contacts); });
  read_of_robots(map, spec, "collision",
                 "a closed-form system has no links that could carry shapes",
                 [&](const YamlReader& r) { read_map(r, spec.collision); });
  read_of_robots(map, spec, "contact_candidates",
                 "a closed-form system has no frames that could touch anything",
                 [&](const YamlReader& r) {
                   kCandidates.read(r, spec.candidates);
                   spec.stepping = SteppingSpec{.place = r.place()};
                 });
  read_of_robots(map, spec, "stepping", "a closed-form system has no joints that could be stopped",
                 [&](const YamlReader& r) { read_map(r, spec.stepping.emplace()); });
  if (!spec.stepping) return;
  map.exclusive({"contact_candidates", "contacts"});
  map.exclusive({"contact_candidates", "gait"});
  map.exclusive({"stepping", "contacts"});
  map.exclusive({"stepping", "gait"});
}

/// The system that a phase names; if the file has several, the name is required.
const NamedSystemSpec* find_system(const PhaseSpec& phase, const ProblemSpec& spec,
                                   Diagnostics& out) {
  std::vector<std::string> names;
  for (const NamedSystemSpec& system : spec.systems) names.push_back(system.name.value);
  if (!phase.system) {
    out.error(phase.name.place,
              fmt::format("the phase '{}' does not say which system moves", phase.name.value),
              "write 'system: " + names.front() + "'", names);
    return nullptr;
  }
  const auto found = std::find(names.begin(), names.end(), phase.system->value);
  if (found != names.end()) return &spec.systems[found - names.begin()];
  out.error(phase.system->place, fmt::format("unknown system '{}'", phase.system->value),
            name_hint(phase.system->value, names, "systems"), names);
  return nullptr;
}

/// Finds the systems of all phases that take time; the first one becomes the problem's system.
void settle_systems(ProblemSpec& spec, Diagnostics& out) {
  if (!spec.system && spec.robots.empty()) return;  // the missing system has been reported
  bool first = true;
  for (const PhaseSpec& phase : spec.phases) {
    if (phase.jump && !spec.system)
      out.error(phase.jump->place, "jumps are for systems, not for robots",
                "write '- {impulse: [contacts]}'");
    if (spec.systems.empty() && phase.system)
      out.error(phase.system->place, "the file has no 'systems' of which a phase could have one");
    if (spec.systems.empty() || phase.takes_no_time()) continue;
    const NamedSystemSpec* system = find_system(phase, spec, out);
    if (system != nullptr && first) spec.system = system->system;
    first = false;
  }
}

/// True for phases that consist of a choice of the start alone.
bool is_choice(const YamlNode& phases) {
  return phases.items.size() == 1 && phases.items.front().find("choose") != nullptr;
}

/// Reads the phases, and the gait that makes those after a choice of the start.
void read_schedule(YamlMap& map, ProblemSpec& spec) {
  const auto phases = map.find("phases");
  if (phases && !is_choice(phases->node())) map.exclusive({"phases", "gait"});
  read_of_robots(map, spec, "gait", "a closed-form system has no feet that could walk",
                 [&](const YamlReader& r) { spec.gait = read_gait(r, spec.contacts); });
  const bool gait = spec.gait.has_value();
  if (const auto r = gait ? phases : map.require("phases")) spec.phases = read_phases(*r, gait);
  settle_systems(spec, map.reader().diagnostics());
}

void read_terminal(const YamlReader& reader, const std::filesystem::path& folder,
                   ProblemSpec& spec) {
  YamlMap terminal(reader);
  if (const auto contacts = terminal.find("contacts"))
    spec.terminal_contacts = read_contact_names(*contacts);
  if (const auto lqr = terminal.find("lqr")) LqrForm().read(*lqr, spec.terminal_lqr.emplace());
  if (const auto costs = terminal.find("costs"))
    spec.terminal_costs = read_costs(*costs, folder, true);
  if (const auto constraints = terminal.find("constraints"))
    read_constraints(*constraints, folder, true, spec);
}

/// Prefix in outputs for names of the last node.
constexpr std::string_view kOfLastNode = "terminal/";

/// Outputs sum by name, so terms need distinct names.
void check_running_name(const Name& name, Diagnostics& out) {
  if (name.value.starts_with(kOfLastNode))
    out.error(name.place,
              fmt::format("in outputs, names '{}...' are reserved for entries under 'terminal'",
                          kOfLastNode),
              "give it another name");
}

/// The same for soft constraints, which outputs list among the costs.
void check_soft_names(const std::vector<ConstraintSpec>& constraints,
                      const std::vector<CostSpec>& costs, Diagnostics& out) {
  for (const ConstraintSpec& constraint : constraints) {
    const Name& name = constraint.function.name;
    if (constraint.softness != Softness::hard &&
        std::ranges::any_of(costs, [&](const CostSpec& c) { return c.name.value == name.value; }))
      out.error(name.place,
                fmt::format("a cost has the name '{}', too, and soft constraints count as costs",
                            name.value),
                "give one of them another name");
  }
}

void check_names(const ProblemSpec& spec, Diagnostics& out) {
  for (const CostSpec& cost : spec.costs) check_running_name(cost.name, out);
  for (const ControlBoundsSpec& bounds : spec.control_bounds) check_running_name(bounds.name, out);
  for (const ConstraintSpec& c : spec.constraints) check_running_name(c.function.name, out);
  check_soft_names(spec.constraints, spec.costs, out);
  check_soft_names(spec.terminal_constraints, spec.terminal_costs, out);
}

/// Reads the costs and constraints of the problem.
void read_terms(YamlMap& map, const std::filesystem::path& folder, ProblemSpec& spec) {
  if (const auto r = map.find("costs")) spec.costs = read_costs(*r, folder, false);
  if (const auto r = map.find("integrals")) spec.integrals = read_integrals(*r, folder);
  if (const auto r = map.find("constraints")) read_constraints(*r, folder, false, spec);
  if (const auto r = map.find("terminal")) read_terminal(*r, folder, spec);
  check_names(spec, map.reader().diagnostics());
}

ProblemSpec read_document(const YamlReader& reader, const std::filesystem::path& file,
                          ExpressionNamesSpec names) {
  const std::filesystem::path folder = file.parent_path();
  ProblemSpec spec;
  spec.file = file;
  spec.name = {file.stem().string(), reader.place()};
  spec.names = std::move(names);
  YamlMap map(reader);
  read_format(map);
  if (const auto r = map.find("name"))
    read_name(*r, spec.name);
  else if (!names_folder(spec.name.value))
    reader.error(fmt::format("the problem has the name of its file, '{}', and {}", spec.name.value,
                             kFolderNameRule),
                 "write 'name: ...'");
  map.text("description", spec.description);
  map.find("parameters");  // already read
  const int errors = reader.diagnostics().error_count();
  if (const auto r = map.find("tables")) spec.names.tables = read_tables(*r, folder);
  spec.names.incomplete = reader.diagnostics().error_count() > errors;
  read_plant(map, folder, spec);
  read_gravity(map, spec);
  read_motion(map, spec);
  read_surroundings(map, spec);
  read_schedule(map, spec);
  read_terms(map, folder, spec);
  if (const auto r = map.find("mesh")) spec.mesh = read_mesh(*r);
  if (const auto r = map.find("initial_guess"))
    GroupValue([&](Keys& keys) { describe(keys, spec.guess, folder); }).read(*r);
  if (const auto r = map.find("perturbation")) read_map(*r, spec.perturbation);
  if (const auto r = map.find("solver")) read_map(*r, spec.solver, "write '{name: box_fddp}'");
  if (const auto r = map.find("mpc")) spec.mpc = read_mpc(*r, folder, spec.solver.name);
  return spec;
}

}  // namespace

std::optional<ProblemDocument> parse_problem(std::string text, const std::filesystem::path& file,
                                             Diagnostics& out) {
  const int source = out.add_source(file.string(), text);
  std::optional<YamlNode> root = parse_yaml(text, source, out);
  if (!root) return std::nullopt;
  if (root->find("conddp_batch") != nullptr && root->find("conddp") == nullptr) {
    out.error({root->mark, {}}, "this is a plan of a batch, not a problem file",
              "'conddp batch run' takes it");
    return std::nullopt;
  }
  return ProblemDocument{file, std::move(text), {}, *std::move(root)};
}

std::optional<ProblemDocument> load_problem(const std::filesystem::path& file, const Place& place,
                                            Diagnostics& out) {
  std::string hash;
  std::optional<std::string> text = read_text(file, kMaxYamlBytes, place, hash, out);
  if (!text) return std::nullopt;
  auto document = parse_problem(*std::move(text), file, out);
  if (document) document->sha256 = hash;
  return document;
}

namespace {

/// Applies settings and the rewritings of the document, up to the one named `last`.
std::optional<DocumentDraft> rewrite(const ProblemDocument& document,
                                     const std::vector<Setting>& settings, double homotopy_share,
                                     std::string_view last, Diagnostics& out) {
  DocumentDraft draft{.root = document.root, .names = {}, .homotopy_share = homotopy_share};
  for (const Setting& setting : settings) apply_setting(draft.root, setting, out);
  for (const DocumentRewriting& rewriting : document_rewritings()) {
    if (out.has_errors()) return std::nullopt;
    rewriting.apply(draft, out);
    if (rewriting.name == last) break;
  }
  if (out.has_errors()) return std::nullopt;
  return draft;
}

std::optional<ProblemSpec> read_with_settings(const ProblemDocument& document,
                                              const std::vector<Setting>& settings,
                                              double homotopy_share, std::string_view last,
                                              Diagnostics& out) {
  auto draft = rewrite(document, settings, homotopy_share, {}, out);
  if (!draft) return std::nullopt;
  ProblemSpec spec =
      read_document(YamlReader(draft->root, {}, out), document.file, std::move(draft->names));
  for (const SpecRewriting& rewriting : spec_rewritings()) {
    if (out.has_errors()) return std::nullopt;
    rewriting.apply(spec, out);
    if (rewriting.name == last) break;
  }
  if (out.has_errors()) return std::nullopt;
  spec.text = document.text;
  spec.sha256 = document.sha256.empty() ? sha256(document.text) : document.sha256;
  spec.definition = canonical_definition(draft->root);
  for (const Setting& setting : settings) spec.settings.push_back(setting.text);
  return spec;
}

}  // namespace

std::optional<ProblemSpec> read_problem(const ProblemDocument& document,
                                        const std::vector<Setting>& settings, Diagnostics& out,
                                        const ReadOptions& options) {
  const Diagnostics before = settings.empty() ? Diagnostics() : out;
  auto spec = read_with_settings(document, settings, options.homotopy_share, options.last, out);
  if (!spec && !settings.empty()) out = with_similar_names(out, before, document.root, settings);
  return spec;
}

std::optional<ProblemSpec> read_problem(const std::optional<ProblemDocument>& document,
                                        const std::vector<std::string>& overrides, Diagnostics& out,
                                        const ReadOptions& options) {
  if (!document) return std::nullopt;
  return read_problem(*document, parse_settings(overrides, out), out, options);
}

std::optional<ProblemSpec> read_problem_text(const std::string& text,
                                             const std::filesystem::path& file,
                                             const std::vector<std::string>& overrides,
                                             Diagnostics& out, const ReadOptions& options) {
  return read_problem(parse_problem(text, file, out), overrides, out, options);
}

std::optional<YamlNode> rewritten_document(const std::string& text,
                                           const std::filesystem::path& file,
                                           const std::vector<std::string>& overrides,
                                           std::string_view rewriting, Diagnostics& out) {
  const auto document = parse_problem(text, file, out);
  if (!document) return std::nullopt;
  auto draft = rewrite(*document, parse_settings(overrides, out), 1, rewriting, out);
  return draft ? std::optional(std::move(draft->root)) : std::nullopt;
}

std::optional<ProblemSpec> read_problem(const std::filesystem::path& file,
                                        const std::vector<std::string>& overrides,
                                        Diagnostics& out) {
  return read_problem(load_problem(file, {}, out), overrides, out);
}

}  // namespace conddp
