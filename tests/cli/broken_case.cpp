#include "broken_case.hpp"

#include <algorithm>
#include <fstream>
#include <stdexcept>

#include <sys/stat.h>

#include <fmt/format.h>

namespace conddp {
namespace {

std::string with_count(std::string text, int count) {
  for (const auto& [mark, value] : {std::pair("{i}", count), std::pair("{i+1}", count + 1)})
    for (std::size_t at; (at = text.find(mark)) != std::string::npos;)
      text.replace(at, std::string_view(mark).size(), std::to_string(value));
  return text;
}

/// A text, or its concatenated pieces.
std::string content(const YAML::Node& node) {
  if (node.IsScalar()) return node.Scalar();
  std::string text;
  if (node.IsSequence()) {
    for (const YAML::Node& piece : node) text += content(piece);
  } else if (node["hex"]) {
    const std::string digits = node["hex"].Scalar();
    for (std::size_t i = 0; i + 1 < digits.size(); i += 2)
      text += static_cast<char>(std::stoi(digits.substr(i, 2), nullptr, 16));
  } else {
    const std::string piece = node["text"].Scalar();
    const int times = node["times"].as<int>();
    const bool counts = piece.find("{i") != std::string::npos;
    for (int i = 0; i < times; ++i) text += counts ? with_count(piece, i) : piece;
  }
  return text;
}

BrokenCase read_case(const YAML::Node& node) {
  BrokenCase broken{.name = node["name"].as<std::string>(""), .node = node};
  for (const auto& entry : node) {
    const std::string key = entry.first.Scalar();
    const std::vector<std::string> known = {"name", "change", "write", "make",
                                            "run",  "says",   "lacks"};
    if (std::find(known.begin(), known.end(), key) == known.end())
      throw std::runtime_error(fmt::format("{}: a case has no key '{}'", broken.name, key));
  }
  broken.arguments = {"solve", "pendulum.yaml", "-o", "out"};
  if (node["run"]) broken.arguments.clear();
  for (const YAML::Node& argument : node["run"]) broken.arguments.push_back(content(argument));
  for (const YAML::Node& line : node["says"]) broken.says.push_back(line.Scalar());
  for (const YAML::Node& text : node["lacks"]) broken.lacks.push_back(text.Scalar());
  if (broken.name.empty() || broken.says.empty())
    throw std::runtime_error(fmt::format("a case lacks its name or 'says': {}", broken.name));
  return broken;
}

void change(const std::filesystem::path& file, const YAML::Node& pairs) {
  std::string text = read_file(file);
  for (std::size_t i = 0; i + 1 < pairs.size(); i += 2) {
    const std::string from = content(pairs[i]);
    const std::size_t at = text.find(from);
    if (at == std::string::npos)
      throw std::runtime_error(fmt::format("'{}' is not in {}", from, file.string()));
    text.replace(at, from.size(), content(pairs[i + 1]));
  }
  std::ofstream(file, std::ios::binary) << text;
}

void make(const std::filesystem::path& folder, const YAML::Node& thing) {
  const auto fresh = [&](const YAML::Node& name) {
    std::filesystem::remove(folder / name.Scalar());
    return folder / name.Scalar();
  };
  if (thing["folder"]) std::filesystem::create_directory(fresh(thing["folder"]));
  if (thing["fifo"] && mkfifo(fresh(thing["fifo"]).c_str(), 0666) != 0)
    throw std::runtime_error("no fifo");
  if (thing["link"])
    std::filesystem::create_symlink(thing["link"][0].Scalar(), fresh(thing["link"][1]));
}

}  // namespace

std::vector<std::string> broken_groups() {
  std::vector<std::string> groups;
  for (const auto& entry : std::filesystem::directory_iterator(source("tests/broken")))
    if (entry.path().extension() == ".yaml") groups.push_back(entry.path().stem().string());
  std::sort(groups.begin(), groups.end());
  return groups;
}

std::vector<BrokenCase> broken_cases(const std::string& group) {
  std::vector<BrokenCase> cases;
  for (const YAML::Node& node : YAML::LoadFile(source("tests/broken/" + group + ".yaml")))
    cases.push_back(read_case(node));
  return cases;
}

void write_good_inputs(const TemporaryFolder& folder) {
  for (const auto& entry : std::filesystem::directory_iterator(source("tests/broken/good")))
    folder.write(entry.path().filename().string(), read_file(entry.path()));
}

void BrokenCase::prepare(const TemporaryFolder& folder) const {
  write_good_inputs(folder);
  for (const auto& file : node["change"]) change(folder.path() / file.first.Scalar(), file.second);
  for (const auto& file : node["write"]) folder.write(file.first.Scalar(), content(file.second));
  for (const YAML::Node& thing : node["make"]) make(folder.path(), thing);
}

}  // namespace conddp
