#pragma once

#include <cstdlib>
#include <fstream>
#include <string>
#include <vector>

#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include "base/text/strict_number.hpp"
#include "problem_file/yaml/yaml_source.hpp"
#include "problem_text.hpp"
#include "support/source_tree.hpp"
#include "support/temporary_folder.hpp"

namespace conddp {

using Json = nlohmann::json;

inline const std::filesystem::path kSchema = source_tree() / "schemas" / "problem.schema.json";

inline Json load_schema() {
  std::ifstream stream(kSchema);
  return Json::parse(stream);
}

inline Json to_json(const YamlNode& node) {
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
    return whole ? Json(std::stoll(node.text)) : Json(*number);
  }
  if (!node.quoted && (node.text == "true" || node.text == "false")) return node.text == "true";
  return node.text;
}

inline std::string read_file(const std::filesystem::path& file) {
  std::ifstream stream(file);
  return {std::istreambuf_iterator<char>(stream), {}};
}

inline std::vector<std::filesystem::path> ready_problems() {
  std::vector<std::filesystem::path> files;
  for (const auto& entry : std::filesystem::directory_iterator(kProblems))
    if (entry.path().extension() == ".yaml") files.push_back(entry.path());
  std::sort(files.begin(), files.end());
  return files;
}

/// Documents that violate the schema according to scripts/validate_json.
inline std::vector<bool> violations(const std::vector<Json>& documents) {
  const TemporaryFolder folder;
  std::string command =
      source_tree().string() + "/scripts/validate_json '" + kSchema.string() + "'";
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
  return found;
}

inline Json parse_to_json(const std::string& text) {
  Diagnostics out;
  const auto root = parse_yaml(text, out.add_source("file.yaml", text), out);
  EXPECT_TRUE(root) << format_diagnostics(out, false);
  return root ? to_json(*root) : Json();
}

}  // namespace conddp
