// Agreement of the plan reader with schemas/batch.schema.json.
#include <cstdlib>

#include <nlohmann/json.hpp>

#include "batch_folder.hpp"
#include "support/source_tree.hpp"

namespace conddp {
namespace {

/// A JSON plan (valid YAML too) with one member added or replaced.
std::string plan_with(const std::string& key, const std::string& value) {
  nlohmann::ordered_json plan = {{"conddp_batch", 1}, {"problem", "swing.yaml"}};
  if (key == "problems") plan.erase("problem");
  if (!key.empty()) plan[key] = nlohmann::ordered_json::parse(value);
  return plan.dump();
}

std::string axis(const std::string& text) { return "{\"a\": " + text + "}"; }

struct Case {
  std::string key, value;
  bool is_valid;
};

const std::vector<Case>& cases() {
  static const std::vector<Case> list = {
      {"", "", true},
      {"conddp_batch", "2", false},
      {"conddp_batch", "\"1\"", false},
      {"name", "\"grid\"", true},
      {"name", "\"a/b\"", false},
      {"name", "\".a\"", false},
      {"name", "\"\"", false},
      {"problem", "[]", false},
      {"problems", "[\"swing.yaml\"]", true},
      {"problems", "[]", false},
      {"problems", "\"swing.yaml\"", false},
      {"unknown", "1", false},
      {"solvers", "[\"ilqr\", \"auto\"]", true},
      {"solvers", "[]", false},
      {"command", "\"mpc\"", true},
      {"command", "\"loop\"", false},
      {"limits", "{\"max_time_s\": 20, \"max_memory_mb\": 2000, \"retries\": 1}", true},
      {"limits", "{}", true},
      {"limits", "{\"max_time_s\": 0}", false},
      {"limits", "{\"max_time_s\": 1e10}", false},
      {"limits", "{\"max_memory_mb\": 99}", false},
      {"limits", "{\"max_memory_mb\": 200.5}", false},
      {"limits", "{\"retries\": 11}", false},
      {"limits", "{\"retries\": -1}", false},
      {"limits", "{\"time\": 1}", false},
      {"limits", "[]", false},
      {"keep", "{\"solutions\": \"all\"}", true},
      {"keep", "{\"solutions\": \"converged\"}", true},
      {"keep", "{\"solutions\": \"none\"}", true},
      {"keep", "{\"solutions\": \"some\"}", false},
      {"keep", "{\"logs\": \"all\"}", false},
      {"warm_start", "\"none\"", true},
      {"warm_start", "\"neighbour\"", true},
      {"warm_start", "[]", false},
      {"vary", "{}", true},
      {"vary", "[]", false},
      {"vary", axis(R"({"key": "k", "linspace": [0, 1, 3]})"), true},
      {"vary", axis(R"({"key": "k", "linspace": [0, 1]})"), false},
      {"vary", axis(R"({"linspace": [0, 1, 3]})"), false},
      {"vary", axis(R"({"key": "k", "values": [1, "a", [2]]})"), true},
      {"vary", axis(R"({"key": "k", "values": []})"), false},
      {"vary", axis(R"({"key": "k"})"), false},
      {"vary", axis(R"({"key": "k", "values": [1], "linspace": [0, 1, 3]})"), false},
      {"vary", axis(R"({"key": "k", "values": [1], "count": 3})"), false},
      {"vary", axis(R"({"keys": ["k", "l"], "values": [[1, 2], [3, 4]]})"), true},
      {"vary", axis(R"({"keys": ["k"], "key": "k", "values": [[1]]})"), false},
      {"vary", axis(R"({"keys": ["k"], "values": [1]})"), false},
      {"vary", axis(R"({"keys": ["k"], "values": []})"), false},
      {"vary", axis(R"({"file": "t.csv", "columns": {"c": "k"}})"), true},
      {"vary", axis(R"({"file": "t.csv"})"), false},
      {"vary", axis(R"({"perturb": "guess", "spread": 0.1, "count": 3})"), true},
      {"vary", axis(R"({"perturb": "initial_state", "spread": 0.1, "count": 3, "seed": 0})"), true},
      {"vary", axis(R"({"perturb": ["initial_state", "guess"], "spread": 0.1, "count": 3})"), true},
      {"vary", axis(R"({"perturb": ["guess", "guess"], "spread": 0.1, "count": 3})"), false},
      {"vary", axis(R"({"perturb": [], "spread": 0.1, "count": 3})"), false},
      {"vary", axis(R"({"normal": {"k": [0, 1], "l": [2, 3]}, "count": 3, "seed": 2})"), true},
      {"vary", axis(R"({"uniform": {"k": [0, 1], "l": [2, 3]}, "count": 3})"), true},
      {"vary", axis(R"({"uniform": {}, "count": 3})"), false},
      {"vary", axis(R"({"key": "k", "normal": {"l": [0, 1]}, "count": 3})"), false},
      {"vary", axis(R"({"file": "t.csv", "columns": {}})"), false},
      {"vary", axis(R"({"perturb": "phases", "spread": 0.1, "count": 3})"), false},
      {"vary", axis(R"({"perturb": "guess", "spread": 0, "count": 3})"), false},
      {"vary", axis(R"({"perturb": "guess", "spread": 0.1})"), false},
      {"vary", axis(R"({"perturb": "guess", "count": 3})"), false},
      {"vary", axis(R"({"key": "k", "uniform": [0, 1], "count": 3, "seed": 2})"), true},
      {"vary", axis(R"({"key": "k", "uniform": [0, 1], "count": 0})"), false},
      {"vary", axis(R"({"key": "k", "uniform": [0, 1], "count": 3, "seed": -1})"), false},
      {"vary", axis(R"({"key": "k", "normal": [0, 1], "count": 3})"), true},
      {"vary", axis(R"({"key": "k", "normal": [0], "count": 3})"), false},
      {"vary", axis(R"({"sobol": {"k": [0, 1], "l": [2, 3]}, "count": 4})"), true},
      {"vary", axis(R"({"sobol": {}, "count": 4})"), false},
      {"vary", axis(R"({"sobol": {"k": 1}, "count": 4})"), false},
      {"vary", axis(R"({"key": "k", "sobol": {"k": [0, 1]}, "count": 4})"), false}};
  return list;
}

/// Output of scripts/validate_json: lines that begin with the document's path.
std::string schema_violations(const std::vector<std::filesystem::path>& documents,
                              const std::filesystem::path& report) {
  const std::string root = source_tree();
  std::string command = root + "/scripts/validate_json " + root + "/schemas/batch.schema.json";
  for (const auto& document : documents) command += ' ' + document.string();
  const int status = std::system((command + " > " + report.string()).c_str());
  EXPECT_TRUE(WIFEXITED(status) && WEXITSTATUS(status) < 2) << "validate_json could not run";
  std::ifstream stream(report);
  return {std::istreambuf_iterator<char>(stream), {}};
}

TEST(BatchSchema, TheReaderAndTheSchemaAgree) {
  const TemporaryFolder folder;
  folder.write("swing.yaml", kSwing);
  folder.write("t.csv", "c\n1\n");
  std::vector<std::filesystem::path> plans;
  for (const auto& [key, value, is_valid] : cases()) {
    plans.push_back(
        folder.write("plan" + std::to_string(plans.size()) + ".json", plan_with(key, value)));
    Diagnostics out;
    EXPECT_EQ(load_batch_plan(plans.back(), out).has_value(), is_valid)
        << key << ": " << value << '\n'
        << format_diagnostics(out, false);
  }
  const std::string violations = schema_violations(plans, folder.path() / "report");
  for (std::size_t i = 0; i < plans.size(); ++i)
    EXPECT_EQ(violations.find(plans[i].string() + ':') == std::string::npos, cases()[i].is_valid)
        << cases()[i].key << ": " << cases()[i].value;
}

// Each key added to or removed from the schema needs a case above.
TEST(BatchSchema, HasTheKeysOfTheCases) {
  std::ifstream stream(source_tree() / "schemas/batch.schema.json");
  const auto schema = nlohmann::json::parse(stream);
  std::string valid;
  for (const Case& c : cases())
    if (c.is_valid) valid += c.key + ' ' + c.value + '\n';
  const auto has = [&](const std::string& key) { return valid.find(key) != std::string::npos; };
  for (const auto& [key, unused] : schema.at("properties").items())
    EXPECT_TRUE(has(key) || key == "conddp_batch" || key == "problem") << key;
  for (const char* section : {"limits", "keep"})
    for (const auto& [key, unused] : schema.at("properties").at(section).at("properties").items())
      EXPECT_TRUE(has('"' + key + '"')) << key;
  for (const auto& kind : schema.at("definitions").at("axis").at("oneOf"))
    for (const auto& [key, unused] : kind.at("properties").items())
      EXPECT_TRUE(has('"' + key + '"')) << key;
}

}  // namespace
}  // namespace conddp
