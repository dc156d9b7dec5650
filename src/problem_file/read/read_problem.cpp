#include "problem_file/read/read_problem.hpp"

#include <fmt/format.h>

#include "base/sha256.hpp"
#include "base/source_text.hpp"
#include "problem_file/read/gait_schedule.hpp"
#include "problem_file/read/homotopy_numbers.hpp"
#include "problem_file/read/read_sections.hpp"
#include "problem_file/spec/enum_names.hpp"
#include "problem_file/yaml/canonical_definition.hpp"
#include "problem_file/yaml/yaml_source.hpp"

namespace conddp {
namespace {

constexpr std::size_t kLongestName = 200;
constexpr NumberRange kSpread{0, kLargestSpread, false, false, "a number from 0 to 1e6"};

void read_plant(YamlMap& map, const std::filesystem::path& folder, ProblemSpec& spec) {
  const auto robot = map.find("robot");
  const auto robots = map.find("robots");
  const auto system = map.find("system");
  map.exclusive({"robot", "robots"});
  map.exclusive({"robot", "system"});
  map.exclusive({"robots", "system"});
  if (robot) spec.robots.push_back(read_robot(*robot, folder));
  if (robots)
    if (const auto entries = robots->named_entries())
      for (const auto& [name, value] : *entries) {
        spec.robots.push_back(read_robot(value, folder));
        spec.robots.back().name = name;
        if (name.value.find_first_of("/,") != std::string::npos)
          map.reader().diagnostics().error(name.place, "a robot's name has no '/' and no ','");
      }
  if (system) spec.system = read_system(*system);
  if (!robot && !robots && !system && map.valid())
    map.reader().error("the file says nothing about what moves: 'robot', 'robots' or 'system'");
  if (const auto r = map.find("gravity")) {
    spec.gravity = read_vector3(*r, "[x, y, z] in m/s²").value_or(spec.gravity);
    if (system) r->error("a closed-form system has its gravity among its parameters");
  }
}

void read_format(YamlMap& map) {
  const auto format = map.require("conddp");
  if (!format) return;
  const auto version = format->integer(1, 1'000'000);
  if (version && *version != kProblemFormat)
    format->error(fmt::format("the file has format {}, and this version reads format {}", *version,
                              kProblemFormat));
}

Perturbation read_perturbation(const YamlReader& reader) {
  Perturbation perturbation;
  YamlMap map(reader);
  if (!map.valid()) return perturbation;
  if (const auto r = map.find("initial_state"))
    perturbation.initial_state = r->number(kSpread).value_or(0);
  if (const auto r = map.find("guess")) perturbation.guess = r->number(kSpread).value_or(0);
  if (const auto r = map.find("seed"))
    perturbation.seed = static_cast<std::uint64_t>(r->integer(0, kLargestSeed).value_or(1));
  return perturbation;
}

ProblemSpec read_document(const YamlReader& reader, const std::filesystem::path& file) {
  const std::filesystem::path folder = file.parent_path();
  ProblemSpec spec{.file = file, .name = {file.stem().string(), reader.place()}};
  YamlMap map(reader);
  read_format(map);
  if (const auto r = map.find("name")) {
    spec.name = r->name().value_or(spec.name);
    if (spec.name.value.find_first_of("/\\") != std::string::npos || spec.name.value[0] == '.')
      r->error("the name is also that of a folder: no '/', no '\\', no '.' in front");
    else if (spec.name.value.size() > kLongestName)
      r->error(fmt::format("the name is also that of a folder: at most {} bytes", kLongestName));
  }
  map.text("description", spec.description);
  read_plant(map, folder, spec);
  if (const auto r = map.require("initial_state"))
    if (auto state = read_state(*r)) spec.initial_state = std::move(*state);
  if (const auto r = map.find("integrator"))
    if (const auto integrator = r->choice(kIntegratorWords, "integrator"))
      spec.integrator = {*integrator, r->place()};
  if (const auto r = map.find("running_costs"))
    spec.running_costs =
        r->choice(kRunningCostsWords, "kind of running costs").value_or(spec.running_costs);
  if (const auto r = map.find("contacts")) {
    spec.contacts = read_contacts(*r);
    if (spec.system) r->error("a closed-form system has no frames that could touch the world");
  }
  if (const auto r = map.find("collision")) {
    spec.collision = read_collision(*r);
    if (spec.system) r->error("a closed-form system has no links that could carry shapes");
  }
  if (const auto r = map.find("contact_candidates")) {
    spec.candidates = read_candidates(*r);
    spec.stepping = SteppingSpec{.place = r->place()};
    if (spec.system) r->error("a closed-form system has no frames that could touch anything");
  }
  if (const auto r = map.find("stepping")) {
    spec.stepping = read_stepping(*r);
    if (spec.system) r->error("a closed-form system has no joints that could be stopped");
  }
  if (spec.stepping) {
    map.exclusive({"contact_candidates", "contacts"});
    map.exclusive({"contact_candidates", "gait"});
    map.exclusive({"stepping", "contacts"});
    map.exclusive({"stepping", "gait"});
  }
  map.exclusive({"phases", "gait"});
  std::optional<GaitSpec> gait;
  if (const auto walk = map.find("gait")) {
    gait = read_gait(*walk, spec.contacts);
    if (spec.system) walk->error("a closed-form system has no feet that could walk");
  }
  if (const auto r = gait ? map.find("phases") : map.require("phases"))
    spec.phases = read_phases(*r);
  if (const auto r = map.find("costs")) spec.costs = read_costs(*r, folder, false);
  if (const auto r = map.find("constraints")) read_constraints(*r, folder, false, spec);
  if (const auto r = map.find("terminal")) {
    YamlMap terminal(*r);
    if (const auto contacts = terminal.find("contacts"))
      spec.terminal_contacts = read_contact_names(*contacts);
    if (const auto costs = terminal.find("costs"))
      spec.terminal_costs = read_costs(*costs, folder, true);
    if (const auto constraints = terminal.find("constraints"))
      read_constraints(*constraints, folder, true, spec);
  }
  if (const auto r = map.find("initial_guess")) spec.guess = read_guess(*r, folder);
  if (const auto r = map.find("perturbation")) spec.perturbation = read_perturbation(*r);
  if (const auto r = map.find("solver")) spec.solver = read_solver(*r);
  if (gait && !reader.diagnostics().has_errors()) add_gait(*gait, spec, reader.diagnostics());
  return spec;
}

}  // namespace

std::optional<ProblemDocument> parse_problem(std::string text, const std::filesystem::path& file,
                                             Diagnostics& out) {
  const int source = out.add_source(file.string(), text);
  std::optional<YamlNode> root = parse_yaml(text, source, out);
  if (!root) return std::nullopt;
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

std::optional<ProblemSpec> read_problem(const ProblemDocument& document,
                                        const std::vector<Setting>& settings, Diagnostics& out,
                                        double homotopy_share) {
  YamlNode root = document.root;
  for (const Setting& setting : settings) apply_setting(root, setting, out);
  if (!out.has_errors()) place_homotopy(root, homotopy_share, out);
  if (out.has_errors()) return std::nullopt;
  ProblemSpec spec = read_document(YamlReader(root, {}, out), document.file);
  if (out.has_errors()) return std::nullopt;
  spec.text = document.text;
  spec.sha256 = document.sha256.empty() ? sha256(document.text) : document.sha256;
  spec.definition = canonical_definition(root);
  for (const Setting& setting : settings) spec.settings.push_back(setting.text);
  return spec;
}

namespace {

std::optional<ProblemSpec> read_with(const ProblemDocument& document,
                                     const std::vector<std::string>& overrides, Diagnostics& out,
                                     double homotopy_share) {
  std::vector<Setting> settings;
  for (const std::string& text : overrides)
    if (auto setting = parse_setting(text, out)) settings.push_back(*std::move(setting));
  return read_problem(document, settings, out, homotopy_share);
}

}  // namespace

std::optional<ProblemSpec> read_problem_text(const std::string& text,
                                             const std::filesystem::path& file,
                                             const std::vector<std::string>& overrides,
                                             Diagnostics& out, double homotopy_share) {
  const auto document = parse_problem(text, file, out);
  if (!document) return std::nullopt;
  return read_with(*document, overrides, out, homotopy_share);
}

std::optional<ProblemSpec> read_problem(const std::filesystem::path& file,
                                        const std::vector<std::string>& overrides,
                                        Diagnostics& out) {
  const auto document = load_problem(file, {}, out);
  if (!document) return std::nullopt;
  return read_with(*document, overrides, out, 1);
}

}  // namespace conddp
