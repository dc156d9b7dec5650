// The reader and schemas/problem.schema.json say the same.
#include <cmath>
#include <cstdlib>
#include <fstream>
#include <set>

#include <unistd.h>

#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include "problem_file/residual_kind.hpp"
#include "problem_file/strict_number.hpp"
#include "problem_file/yaml_source.hpp"
#include "problem_text.hpp"
#include "solvers/option_table.hpp"
#include "solvers/registry.hpp"

namespace conddp {
namespace {

using Json = nlohmann::json;

const std::filesystem::path kSchema =
    std::filesystem::path(CONDDP_SOURCE_DIR) / "schemas" / "problem.schema.json";

Json load_schema() {
  std::ifstream stream(kSchema);
  return Json::parse(stream);
}

Json to_json(const YamlNode& node) {
  switch (node.kind) {
    case YamlNode::Kind::kNull:
      return nullptr;
    case YamlNode::Kind::kSequence: {
      Json list = Json::array();
      for (const YamlNode& item : node.items) list.push_back(to_json(item));
      return list;
    }
    case YamlNode::Kind::kMap: {
      Json map = Json::object();
      for (const YamlNode::Entry& entry : node.entries) map[entry.key] = to_json(entry.value);
      return map;
    }
    case YamlNode::Kind::kScalar:
      break;
  }
  if (const auto number = parse_number(node.text).value; number && !node.quoted) {
    const bool whole = node.text.find_first_of(".eE") == std::string::npos;
    return whole ? Json(static_cast<long long>(*number)) : Json(*number);
  }
  if (!node.quoted && (node.text == "true" || node.text == "false")) return node.text == "true";
  return node.text;
}

std::string read_file(const std::filesystem::path& file) {
  std::ifstream stream(file);
  return {std::istreambuf_iterator<char>(stream), {}};
}

std::vector<std::filesystem::path> ready_problems() {
  std::vector<std::filesystem::path> files;
  for (const auto& entry : std::filesystem::directory_iterator(kProblems))
    if (entry.path().extension() == ".yaml") files.push_back(entry.path());
  std::sort(files.begin(), files.end());
  return files;
}

/// Which documents do not fit the schema, as scripts/validate_json sees it.
std::vector<bool> violations(const std::vector<Json>& documents) {
  char folder_name[] = "/tmp/conddp_schema_XXXXXX";
  const std::filesystem::path folder = mkdtemp(folder_name);
  std::string command =
      std::string(CONDDP_SOURCE_DIR) + "/scripts/validate_json '" + kSchema.string() + "'";
  for (std::size_t i = 0; i < documents.size(); ++i) {
    const std::filesystem::path file = folder / (std::to_string(i) + ".json");
    std::ofstream(file) << documents[i].dump();
    command += " " + file.string();
  }
  const int status = std::system((command + " > " + (folder / "report").string()).c_str());
  EXPECT_TRUE(WIFEXITED(status) && WEXITSTATUS(status) < 2) << "validate_json could not run";
  const std::string report = read_file(folder / "report");
  std::vector<bool> found;
  for (std::size_t i = 0; i < documents.size(); ++i)
    found.push_back(report.find("/" + std::to_string(i) + ".json: ") != std::string::npos);
  std::filesystem::remove_all(folder);
  return found;
}

Json parse_to_json(const std::string& text) {
  Diagnostics out;
  const auto root = parse_yaml(text, out.add_source("file.yaml", text), out);
  EXPECT_TRUE(root) << format_diagnostics(out, false);
  return root ? to_json(*root) : Json();
}

TEST(Schema, EveryReadyProblemFitsAndBuilds) {
  const auto files = ready_problems();
  EXPECT_GE(files.size(), 9u);
  std::vector<Json> documents;
  for (const auto& file : files) {
    const std::string text = read_file(file);
    EXPECT_TRUE(
        text.starts_with("# yaml-language-server: $schema=../schemas/problem.schema.json\n"))
        << file;
    documents.push_back(parse_to_json(text));
    Diagnostics out;
    const auto spec = read_problem(file, {}, out);
    ASSERT_TRUE(spec) << format_diagnostics(out, false);
    EXPECT_TRUE(build_problem(*spec, {}, out)) << format_diagnostics(out, false);
    EXPECT_EQ(spec->name.value, file.stem().string()) << "a problem is named like its file";
  }
  const std::vector<bool> bad = violations(documents);
  for (std::size_t i = 0; i < files.size(); ++i) EXPECT_FALSE(bad[i]) << files[i];
}

TEST(Schema, RefusesWhatTheReaderRefuses) {
  const std::pair<const char*, const char*> mistakes[] = {
      {"weight: 0.5", "wieght: 0.5"},       {"knots: 4", "knots: 0"},
      {"dt: 0.1", "dt: 0.1, duration: 2"},  {"conddp: 1", "conddp: 2"},
      {"residual: control", "residual: x"}, {"bounds: control", "bounds: state"},
      {"name: box_ddp", "max_iter: 3"},     {"type: pendulum", "type: pendulum, arm: 1"}};
  std::vector<Json> documents = {parse_to_json(std::string(kPendulum))};
  for (const auto& [from, to] : mistakes) {
    documents.push_back(parse_to_json(replaced(kPendulum, from, to)));
    EXPECT_FALSE(Loaded(replaced(kPendulum, from, to)).built) << to;
  }
  const std::vector<bool> bad = violations(documents);
  EXPECT_FALSE(bad[0]);
  for (std::size_t i = 1; i < bad.size(); ++i) EXPECT_TRUE(bad[i]) << mistakes[i - 1].second;
}

/// The keys that the reader accepts where `text` has the unknown key `zzzzzzzz`.
std::set<std::string> accepted_keys(const std::string& text) {
  Diagnostics out;
  read_problem_text(text, kProblems / "test.yaml", {}, out);
  for (const Diagnostic& d : out.list())
    if (d.message.find("there is no key 'zzzzzzzz'") == 0)
      return {d.accepted.begin(), d.accepted.end()};
  return {};
}

std::set<std::string> schema_keys(const Json& object) {
  std::set<std::string> keys;
  for (const auto& [key, value] : object.at("properties").items()) keys.insert(key);
  return keys;
}

TEST(Schema, HasTheReadersKeys) {
  const Json schema = load_schema();
  const Json& d = schema["definitions"];
  const auto with = [](const char* from, const char* to) { return replaced(kPendulum, from, to); };
  const auto robot = [](const char* from, const char* to) { return replaced(kCartpole, from, to); };
  EXPECT_EQ(accepted_keys(std::string(kPendulum) + "zzzzzzzz: 1\n"), schema_keys(schema));
  EXPECT_EQ(accepted_keys(with("dt: 0.1", "dt: 0.1, zzzzzzzz: 1")), schema_keys(d["phase"]));
  EXPECT_EQ(accepted_keys(with("weight: 0.5", "zzzzzzzz: 1")), schema_keys(d["cost"]));
  EXPECT_EQ(accepted_keys(with("weight: 10", "zzzzzzzz: 1")), schema_keys(d["terminal_cost"]));
  EXPECT_EQ(accepted_keys(with("terminal:", "terminal:\n  zzzzzzzz: 1")),
            schema_keys(schema["properties"]["terminal"]));
  EXPECT_EQ(accepted_keys(with("lower: -3", "zzzzzzzz: 1")), schema_keys(d["constraint"]));
  EXPECT_EQ(accepted_keys(with("{values: {theta: 0.1}}", "{zzzzzzzz: 1}")),
            schema_keys(d["state"]));
  EXPECT_EQ(accepted_keys(with("weight: 0.5", "activation: {kind: smooth_l1, zzzzzzzz: 1}")),
            schema_keys(d["activation"]["anyOf"][1]));
  EXPECT_EQ(accepted_keys(with("solver:", "initial_guess: {zzzzzzzz: 1}\nsolver:")),
            schema_keys(d["initial_guess"]));
  EXPECT_EQ(accepted_keys(with("solver:",
                               "initial_guess: {states: {keyframes: [{time: 1, state: "
                               "[1, 2], zzzzzzzz: 1}]}}\nsolver:")),
            schema_keys(d["keyframe"]));
  EXPECT_EQ(accepted_keys(with("name: box_ddp", "zzzzzzzz: 1")), schema_keys(d["solver"]));
  for (const char* group : {"tolerances", "regularization", "line_search", "box_qp"})
    EXPECT_EQ(
        accepted_keys(with("name: box_ddp", (std::string(group) + ": {zzzzzzzz: 1}").c_str())),
        schema_keys(d["solver"]["properties"][group]));
  EXPECT_EQ(accepted_keys(robot("actuation:", "zzzzzzzz: 1\n  actuation:")),
            schema_keys(d["robot"]));
  EXPECT_EQ(accepted_keys(robot("{joints: [slider]}", "{joints: [slider], zzzzzzzz: 1}")),
            schema_keys(d["actuation"]["anyOf"][1]));
  EXPECT_EQ(accepted_keys(
                robot("{joints: [slider]}", "{thrusters: [{name: a, frame: tip, zzzzzzzz: 1}]}")),
            schema_keys(d["thruster"]));
  EXPECT_EQ(accepted_keys(robot("actuation:", "passive: {zzzzzzzz: 1}\n  actuation:")),
            schema_keys(d["robot"]["properties"]["passive"]));
  EXPECT_EQ(
      accepted_keys(robot("actuation:", "payloads: {pole: {mass: 1, zzzzzzzz: 1}}\n  actuation:")),
      schema_keys(d["payload"]));
  EXPECT_EQ(accepted_keys(robot("actuation:", "placement: {zzzzzzzz: 1}\n  actuation:")),
            schema_keys(d["pose"]));
  EXPECT_EQ(accepted_keys(robot("{configuration: up}", "{base: {zzzzzzzz: 1}}")),
            schema_keys(d["base_state"]));
  for (const Json& system : d["system"]["oneOf"]) {
    const std::string type = system["properties"]["type"]["const"];
    EXPECT_EQ(accepted_keys(with("type: pendulum", ("type: " + type + ", zzzzzzzz: 1").c_str())),
              schema_keys(system))
        << type;
  }
}

TEST(Schema, HasTheSolversOptionsWithDefaultsAndRanges) {
  const Json solver = load_schema()["definitions"]["solver"]["properties"];
  for (const OptionInfo& info : option_table()) {
    const std::size_t dot = info.name.find('.');
    const Json& entry = dot == std::string_view::npos
                            ? solver[std::string(info.name)]
                            : solver[std::string(info.name.substr(0, dot))]["properties"]
                                    [std::string(info.name.substr(dot + 1))];
    EXPECT_EQ(entry["description"], info.doc) << info.name;
    Json expected;
    std::visit([&](const auto& value) { expected = value; }, info.default_value());
    if (expected.is_number_float() && !std::isfinite(expected.get<double>())) expected = nullptr;
    EXPECT_EQ(entry.value("default", Json()), expected) << info.name;
    if (!info.choices.empty()) continue;
    EXPECT_EQ(entry.at(info.min_excluded ? "exclusiveMinimum" : "minimum"), info.min) << info.name;
  }
  std::vector<std::string> names;
  for (const SolverInfo& info : solvers()) names.emplace_back(info.name);
  EXPECT_EQ(solver["name"]["enum"], Json(names));
  EXPECT_EQ(solver["name"]["default"], SolverSpec().name.value);
}

TEST(Schema, HasTheReadersDefaults) {
  const Json d = load_schema()["definitions"];
  const Json systems = d["system"]["oneOf"];
  const auto of = [&](const std::string& type, const char* key) -> double {
    for (const Json& system : systems)
      if (system["properties"]["type"]["const"] == type)
        return system["properties"][key]["default"];
    return NAN;
  };
  EXPECT_EQ(of("pendulum", "inertia"), PendulumParameters().inertia);
  EXPECT_EQ(of("pendulum", "damping"), PendulumParameters().damping);
  EXPECT_EQ(of("cartpole", "pole_mass"), CartpoleParameters().pole_mass);
  EXPECT_EQ(of("acrobot", "friction"), AcrobotParameters().friction);
  EXPECT_EQ(of("car", "wheelbase"), CarSpec().wheelbase);
  EXPECT_EQ(of("planar_quadrotor", "arm"), PlanarQuadrotorParameters().arm);
  EXPECT_EQ(of("quadrotor", "jz"), QuadrotorParameters().jz);
  EXPECT_EQ(of("quadrotor", "torque_ratio"), QuadrotorParameters().torque_ratio);
  EXPECT_EQ(d["cost"]["properties"]["weight"]["default"], CostSpec().weight);
  EXPECT_EQ(d["activation"]["anyOf"][1]["properties"]["epsilon"]["default"],
            ActivationSpec().epsilon);
  EXPECT_EQ(d["robot"]["properties"]["passive"]["properties"]["friction_velocity"]["default"],
            PassiveSpec().friction_velocity);
}

/// Every property name of a schema, at any depth.
void collect_keys(const Json& node, std::set<std::string>& keys) {
  if (node.is_object() && node.contains("properties"))
    for (const auto& [key, value] : node["properties"].items()) keys.insert(key);
  if (node.is_structured())
    for (const auto& [key, value] : node.items()) collect_keys(value, keys);
}

TEST(Schema, EveryKeyStandsInTheReference) {
  const std::string text =
      read_file(std::filesystem::path(CONDDP_SOURCE_DIR) / "docs" / "problem_file.md");
  std::set<std::string> keys;
  collect_keys(load_schema(), keys);
  EXPECT_GT(keys.size(), 80u);
  for (const std::string& key : keys) {
    const bool alone = text.find("`" + key + "`") != std::string::npos;
    bool inside = false;  // of a longer piece of code
    for (std::size_t at = text.find(key); at != std::string::npos && !inside;
         at = text.find(key, at + 1)) {
      const std::size_t line = text.rfind('\n', at) + 1;
      inside = std::count(text.begin() + line, text.begin() + at, '`') % 2 == 1;
    }
    EXPECT_TRUE(alone || inside) << "docs/problem_file.md does not mention " << key;
  }
}

TEST(Schema, TheExampleOfTheReferenceBuilds) {
  const std::string text =
      read_file(std::filesystem::path(CONDDP_SOURCE_DIR) / "docs" / "problem_file.md");
  const std::size_t start = text.find("```yaml\nconddp: 1") + 8;
  const Loaded loaded(text.substr(start, text.find("```", start) - start));
  EXPECT_TRUE(loaded.built) << loaded.all();
}

TEST(Schema, NamesTheReadersResiduals) {
  std::vector<std::string> names;
  for (const ResidualInfo& info : residual_table()) {
    names.emplace_back(info.name);
    EXPECT_EQ(residual_info(info.kind).name, info.name);
  }
  EXPECT_EQ(load_schema()["definitions"]["cost"]["properties"]["residual"]["enum"], Json(names));
}

}  // namespace
}  // namespace conddp
