// Agreement of the reader with schemas/problem.schema.json.
#include <cmath>
#include <cstring>
#include <set>

#include <gtest/gtest.h>

#include "problem_file/assemble/build_problem.hpp"
#include "problem_file/residuals/residual_table.hpp"
#include "problem_file/yaml/synonyms.hpp"
#include "problem_text.hpp"
#include "schema_document.hpp"
#include "solvers/common/option_table.hpp"
#include "solvers/strategies/registry.hpp"
#include "support/source_tree.hpp"
#include "systems/closed_forms/catalogue.hpp"

namespace conddp {
namespace {

TEST(Schema, EveryExampleFitsAndBuilds) {
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

// Users name these columns in references, bounds, and weights.
TEST(Schema, DescribesSystemsByColumnNames) {
  const Eigen::MatrixXd one = Eigen::MatrixXd::Identity(1, 1);
  const std::pair<const char*, std::shared_ptr<const System>> systems[] = {
      {"double_integrator", double_integrator(1)},
      {"linear", linear_system(one, one, Eigen::VectorXd::Zero(1))},
      {"pendulum", pendulum({})},
      {"cartpole", cartpole({})},
      {"acrobot", acrobot({})},
      {"unicycle", unicycle()},
      {"car", car(2, 0.1)},
      {"planar_quadrotor", planar_quadrotor({})},
      {"quadrotor", quadrotor({})},
      {"lander", lander({})}};
  const Json types = load_schema().at("definitions").at("system").at("oneOf");
  EXPECT_EQ(types.size(), std::size(systems) + 2);  // and two types with columns named in the file
  for (const auto& [name, system] : systems)
    for (const Json& type : types) {
      const Json& head = type.at("properties").at("type");
      if (head.at("const") != name) continue;
      std::string words = head.at("description");
      for (char& letter : words)
        if (std::strchr("(),;", letter) != nullptr) letter = ' ';
      words = " " + words + " ";
      for (const auto* columns : {&system->state_columns(), &system->control_columns()})
        for (const Column& column : *columns)
          EXPECT_NE(words.find(" " + column.name + " "), std::string::npos)
              << name << " does not name " << column.name << ": " << words;
    }
}

TEST(Schema, RejectsWhatTheReaderRejects) {
  const std::pair<const char*, const char*> mistakes[] = {
      {"weight: 0.5", "wieght: 0.5"},       {"knots: 4", "knots: 0"},
      {"dt: 0.1", "dt: 0.1, duration: 2"},  {"conddp: 1", "conddp: 2"},
      {"residual: control", "residual: x"}, {"bounds: control", "bounds: forces"},
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

TEST(Schema, AcceptsFormulasForNumbersAndLists) {
  std::vector<Json> documents;
  for (const auto& entry : std::filesystem::directory_iterator(kProblems / "collection"))
    if (entry.path().extension() == ".yaml")
      documents.push_back(parse_to_json(read_file(entry.path())));
  const std::size_t good = documents.size();
  EXPECT_GT(good, 20u);
  for (const char* weight : {"2*mass", "heavy"})
    documents.push_back(
        parse_to_json(replaced(kPendulum, "weight: 0.5", std::string("weight: ") + weight)));
  const std::vector<bool> bad = violations(documents);
  for (std::size_t i = 0; i < documents.size(); ++i) EXPECT_EQ(bad[i], i >= good) << documents[i];
}

/// All property names and enumerated words in a part of the schema.
void collect_words(const Json& part, std::set<std::string>& words) {
  if (part.is_array())
    for (const Json& item : part) collect_words(item, words);
  if (!part.is_object()) return;
  for (const auto& [key, value] : part.items()) {
    if (key == "properties")
      for (const auto& [name, unused] : value.items()) words.insert(name);
    if (key == "enum" || key == "const")
      for (const Json& word : key == "enum" ? value : Json::array({value}))
        if (word.is_string()) words.insert(word.get<std::string>());
    collect_words(value, words);
  }
}

TEST(Schema, HasEverySynonymOfOtherTools) {
  std::set<std::string> words;
  collect_words(load_schema(), words);
  EXPECT_TRUE(words.count("frame_placement") && words.count("at_least"));
  for (const Synonyms& entry : synonyms())
    EXPECT_TRUE(words.count(std::string(entry.ours))) << entry.ours;
}

/// Keys that the reader accepts where `text` has the unknown key `zzzzzzzz`.
std::set<std::string> accepted_keys(const std::string& text) {
  Diagnostics out;
  read_problem_text(text, kProblems / "test.yaml", {}, out);
  for (const Diagnostic& d : out.list())
    if (d.message.find("unknown key 'zzzzzzzz'") == 0)
      return {d.accepted.begin(), d.accepted.end()};
  return {};
}

/// Excludes deprecated names, which are read but not offered.
std::set<std::string> schema_keys(const Json& object) {
  std::set<std::string> keys;
  for (const auto& [key, value] : object.at("properties").items())
    if (!value.value("deprecated", false)) keys.insert(key);
  return keys;
}

TEST(Schema, HasTheReadersKeys) {
  const Json schema = load_schema();
  const Json& d = schema["definitions"];
  const auto with = [](const char* from, const char* to) { return replaced(kPendulum, from, to); };
  const auto robot = [](const char* from, const char* to) { return replaced(kCartpole, from, to); };
  EXPECT_EQ(accepted_keys(std::string(kPendulum) + "zzzzzzzz: 1\n"), schema_keys(schema));
  EXPECT_EQ(accepted_keys(with("dt: 0.1", "dt: 0.1, zzzzzzzz: 1")), schema_keys(d["phase"]));
  EXPECT_EQ(accepted_keys(with("dt: 0.1", "dt: 0.1, refine: {zzzzzzzz: 1}")),
            schema_keys(d["phase"]["properties"]["refine"]));
  EXPECT_EQ(accepted_keys(with("weight: 0.5", "swing: {zzzzzzzz: 1}")), schema_keys(d["swing"]));
  EXPECT_EQ(accepted_keys(std::string(kPendulum) + "contacts: {a: {zzzzzzzz: 1}}\n"),
            schema_keys(d["contact"]));
  EXPECT_EQ(accepted_keys(std::string(kPendulum) + "contacts: {defaults: {zzzzzzzz: 1}}\n"),
            schema_keys(d["contact_defaults"]));
  EXPECT_EQ(accepted_keys(std::string(kPendulum) + "contacts: {a: {baumgarte: {zzzzzzzz: 1}}}\n"),
            schema_keys(d["contact"]["properties"]["baumgarte"]));
  const auto collision = [](const std::string& text) {
    return std::string(kPendulum) + "collision: {" + text + "}\n";
  };
  EXPECT_EQ(accepted_keys(collision("zzzzzzzz: 1")),
            schema_keys(schema["properties"]["collision"]));
  EXPECT_EQ(accepted_keys(collision("shapes: {a: {zzzzzzzz: 1}}")), schema_keys(d["shape"]));
  EXPECT_EQ(accepted_keys(collision("obstacles: {a: {zzzzzzzz: 1}}")), schema_keys(d["obstacle"]));
  for (const std::string form : {"sphere", "capsule", "half_space", "box", "cylinder", "hull"})
    EXPECT_EQ(accepted_keys(collision("obstacles: {a: {" + form + ": {zzzzzzzz: 1}}}")),
              schema_keys(d[form]));
  const auto candidate = [](const std::string& text) {
    return std::string(kPendulum) + "contact_candidates: {a: {" + text + "}}\n";
  };
  EXPECT_EQ(accepted_keys(candidate("zzzzzzzz: 1")), schema_keys(d["contact_candidate"]));
  EXPECT_EQ(accepted_keys(candidate("against: {zzzzzzzz: 1}")),
            schema_keys(d["touched"]["anyOf"][1]));
  EXPECT_EQ(accepted_keys(candidate("against: {box: {zzzzzzzz: 1}}")), schema_keys(d["box"]));
  EXPECT_EQ(accepted_keys(std::string(kPendulum) + "perturbation: {zzzzzzzz: 1}\n"),
            schema_keys(d["perturbation"]));
  const auto mpc = [](const std::string& text) {
    return std::string(kPendulum) + "mpc: {horizon: 1, tick: 1, duration: 1, " + text + "}\n";
  };
  const Json& m = d["mpc"]["properties"];
  const Json& disturbances = m["disturbances"]["items"]["anyOf"];
  EXPECT_EQ(accepted_keys(mpc("zzzzzzzz: 1")), schema_keys(d["mpc"]));
  for (const char* key : {"feedback", "plant", "fallback"})
    EXPECT_EQ(accepted_keys(mpc(std::string(key) + ": {zzzzzzzz: 1}")), schema_keys(m[key]));
  EXPECT_EQ(accepted_keys(mpc("disturbances: [{at: 1, jump: [1], zzzzzzzz: 1}]")),
            schema_keys(disturbances[0]));
  EXPECT_EQ(accepted_keys(mpc("disturbances: [{noise: state, zzzzzzzz: 1}]")),
            schema_keys(disturbances[2]));
  EXPECT_EQ(accepted_keys(std::string(kPendulum) + "stepping: {zzzzzzzz: 1}\n"),
            schema_keys(d["stepping"]));
  const auto gait = [&](const char* keys) {
    return std::string(kPendulum) + "gait: {type: jump, " + keys + "}\n";
  };
  const Json& g = d["gait"]["properties"];
  EXPECT_EQ(accepted_keys(gait("zzzzzzzz: 1")), schema_keys(d["gait"]));
  EXPECT_EQ(accepted_keys(gait("step: {zzzzzzzz: 1}")), schema_keys(g["step"]));
  EXPECT_EQ(accepted_keys(gait("stand: {zzzzzzzz: 1}")), schema_keys(g["stand"]));
  EXPECT_EQ(accepted_keys(with("weight: 0.5", "zzzzzzzz: 1")), schema_keys(d["cost"]));
  EXPECT_EQ(accepted_keys(with("weight: 10", "zzzzzzzz: 1")), schema_keys(d["terminal_cost"]));
  EXPECT_EQ(accepted_keys(with("terminal:", "terminal:\n  zzzzzzzz: 1")),
            schema_keys(schema["properties"]["terminal"]));
  EXPECT_EQ(accepted_keys(with("lower: -3", "zzzzzzzz: 1")), schema_keys(d["constraint"]));
  EXPECT_EQ(accepted_keys(with("bounds: control, lower: -3", "residual: state, zzzzzzzz: 1")),
            schema_keys(d["residual_constraint"]));
  EXPECT_EQ(accepted_keys(
                with("terminal:", "terminal:\n  constraints: {a: {residual: state, zzzzzzzz: 1}}")),
            schema_keys(d["terminal_constraint"]));
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
  EXPECT_EQ(accepted_keys(with("solver:",
                               "initial_guess: {states: {keyframes: [{time: 1, state: [1, 2]}], "
                               "zzzzzzzz: 1}}\nsolver:")),
            schema_keys(d["initial_guess"]["properties"]["states"]["anyOf"][1]));
  EXPECT_EQ(accepted_keys(with("bounds: control, lower: -3",
                               "residual: state, columns: theta, at_least: 1, "
                               "centers: [{from: [4], zzzzzzzz: 1}]")),
            schema_keys(d["line_of_centers"]));
  EXPECT_EQ(accepted_keys(with("name: box_ddp", "zzzzzzzz: 1")), schema_keys(d["solver"]));
  for (const char* group :
       {"tolerances", "regularization", "augmented_lagrangian", "complementarity", "restarts"})
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
    const char* top = info.max_excluded ? "exclusiveMaximum" : "maximum";
    EXPECT_EQ(entry.value(top, HUGE_VAL), info.max) << info.name;
  }
  std::vector<std::string> names{"auto"};
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
  EXPECT_EQ(of("lander", "fuel_rate"), LanderParameters().fuel_rate);
  EXPECT_EQ(of("lander", "mass"), LanderParameters().mass);
  EXPECT_EQ(d["cost"]["properties"]["weight"]["default"], CostSpec().weight);
  EXPECT_EQ(d["activation"]["anyOf"][1]["properties"]["epsilon"]["default"],
            ActivationSpec().epsilon);
  EXPECT_EQ(d["robot"]["properties"]["passive"]["properties"]["friction_velocity"]["default"],
            PassiveSpec().friction_velocity);
}

const std::filesystem::path kReference = source_tree() / "docs" / "problem_file.md";

int run(const std::string& command) {
  const int status = std::system((source_tree().string() + "/" + command).c_str());
  return WIFEXITED(status) ? WEXITSTATUS(status) : -1;
}

TEST(Schema, EveryKeyIsInTheReference) {
  EXPECT_EQ(run("scripts/document_keys --check"), 0) << "run scripts/document_keys";
}

TEST(Schema, YamlInTheReferenceReadsAndBuilds) {
  const std::string text = read_file(kReference);
  const std::string open = "```yaml\n";
  int pieces = 0, files = 0;
  for (std::size_t at = text.find(open); at != std::string::npos; at = text.find(open, at + 1)) {
    const std::size_t start = at + open.size();
    const std::string piece = text.substr(start, text.find("```", start) - start);
    ++pieces;
    if (piece.starts_with("#")) continue;  // comments only
    parse_to_json(piece);
    if (piece.find("conddp: 1") == std::string::npos) continue;
    ++files;
    const Loaded loaded(piece);
    EXPECT_TRUE(loaded.built) << loaded.all();
  }
  EXPECT_GE(pieces, 2);
  EXPECT_GE(files, 1);
}

TEST(Schema, ExamplesAndDefaultsOfEverySchemaFitIt) {
  for (const char* name : {"problem", "solution", "check"})
    EXPECT_EQ(run(std::string("scripts/validate_json --examples ") + source_tree().string() +
                  "/schemas/" + name + ".schema.json"),
              0)
        << name;
}

/// Required members of every part of a schema.
struct SchemaWalk {
  const Json& schema;
  bool examples;  ///< true if objects need an example
  std::vector<std::string> faults;

  const Json& target(const Json& part) const {
    if (part.contains("$ref")) {
      const std::string link = part["$ref"];
      return schema.at(Json::json_pointer(link.substr(1)));
    }
    return part.contains("allOf") ? target(part["allOf"][0]) : part;
  }
  static bool is_number(const Json& part) {
    const Json type = part.value("type", Json());
    if (type == "array") return part.contains("items") && is_number(part["items"]);
    if (type == "object")
      return part.contains("additionalProperties") && part["additionalProperties"].is_object() &&
             is_number(part["additionalProperties"]);
    if (type.is_array()) return std::find(type.begin(), type.end(), "number") != type.end();
    return type == "number";
  }
  void walk(const Json& part, const std::string& path) {
    if (part.is_array())
      for (std::size_t i = 0; i < part.size(); ++i) walk(part[i], path + "/" + std::to_string(i));
    if (!part.is_object()) return;
    if (examples && part.contains("properties") && !part.contains("examples"))
      faults.push_back(path + " is an object without an example");
    if (part.contains("properties") && part["properties"].is_object())
      for (const auto& [key, value] : part["properties"].items()) {
        const std::string words = value.contains("$ref") ? target(value).value("description", "")
                                                         : value.value("description", "");
        if (words.empty()) faults.push_back(path + "/" + key + " has no description");
        if (is_number(target(value)) && !states_unit(words) && !is_dimensionless(path, key))
          faults.push_back(path + "/" + key + " does not say its unit: " + words);
      }
    for (const auto& [key, value] : part.items())
      if (key != "examples" && key != "default" && key != "enum") walk(value, path + "/" + key);
  }
  static bool states_unit(const std::string& words) {
    for (const char* unit : {" unit", "quaternion", "Quaternion"})
      if (words.find(unit) != std::string::npos) return true;
    static const std::set<std::string> kUnits = {"m",     "s",        "kg",       "kg m²", "m/s²",
                                                 "J",     "rad",      "N",        "Nm",    "m/s",
                                                 "rad/s", "Nm per N", "Nm s/rad", "1/s",   "1/s²"};
    // A unit ends a clause: "..., rad or m".
    std::string clause;
    for (const char c : words + ",") {
      if (c != ',' && c != ';' && c != '(' && c != ')' && c != '.') {
        clause += c;
        continue;
      }
      for (const std::string& unit : kUnits) {
        const std::string padded = " " + clause;
        if (padded.ends_with(" " + unit) || padded.find(" " + unit + " ") != std::string::npos)
          return true;
      }
      clause.clear();
    }
    return false;
  }
  static bool is_dimensionless(const std::string& path, const std::string& key) {
    // Weights, directions, matrices, parameters of user functions, and unitless numbers of solvers.
    static const std::set<std::string> kKeys = {"weights", "direction", "A",
                                                "B",       "c",         "parameters"};
    if (kKeys.contains(key) || path.ends_with("/state")) return true;
    for (const char* group : {"/regularization", "/augmented_lagrangian", "/gains", "/multipliers",
                              "/log/items", "/trajectory", "/worst", "/residuals"})
      if (path.find(group) != std::string::npos) return true;
    return key == "cost" || key == "cost_by_name" || key == "state" || key == "tolerance" ||
           key == "values";
  }
};

TEST(Schema, EveryKeyHasUnitsAndObjectsHaveExamples) {
  for (const char* name : {"problem", "solution", "check"}) {
    std::ifstream stream(kSchema.parent_path() / (std::string(name) + ".schema.json"));
    const Json schema = Json::parse(stream);
    SchemaWalk walk{schema, name == std::string("problem"), {}};
    walk.walk(schema, "");
    for (const std::string& fault : walk.faults) ADD_FAILURE() << name << ": " << fault;
  }
}

TEST(Schema, NamesTheReadersResiduals) {
  std::vector<std::string> names;
  for (const ResidualDefinition* definition : residual_table()) {
    names.emplace_back(definition->name);
    EXPECT_EQ(find_residual(definition->name), definition);
  }
  EXPECT_EQ(load_schema()["definitions"]["cost"]["properties"]["residual"]["enum"], Json(names));
}

}  // namespace
}  // namespace conddp
