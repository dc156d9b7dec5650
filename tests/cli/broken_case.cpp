#include "broken_case.hpp"

#include <algorithm>
#include <ostream>
#include <stdexcept>

#include <sys/stat.h>

#include <fmt/format.h>
#include <yaml-cpp/yaml.h>

namespace conddp {
namespace {

std::string with_count(std::string text, int count) {
  for (const auto& [mark, value] : {std::pair("{i}", count), std::pair("{i+1}", count + 1)})
    for (std::size_t at; (at = text.find(mark)) != std::string::npos;)
      text.replace(at, std::string_view(mark).size(), std::to_string(value));
  return text;
}

/// A text, or pieces of one.
std::string content(const YAML::Node& node) {
  if (node.IsScalar()) return node.Scalar();
  std::string text;
  if (node.IsSequence()) {
    for (const auto& piece : node) text += content(piece);
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

BrokenCase read_case(const YAML::Node& node, const std::string& group) {
  BrokenCase broken{.group = group};
  for (const auto& entry : node) {
    const std::string key = entry.first.Scalar();
    const YAML::Node value = entry.second;
    if (key == "name") {
      broken.name = value.Scalar();
    } else if (key == "change") {
      for (const auto& change : value)
        for (std::size_t i = 0; i + 1 < change.second.size(); i += 2)
          broken.changes.push_back(
              {change.first.Scalar(), content(change.second[i]), content(change.second[i + 1])});
    } else if (key == "write") {
      for (const auto& file : value)
        broken.writes.emplace_back(file.first.Scalar(), content(file.second));
    } else if (key == "make") {
      for (const auto& thing : value) {
        if (thing["folder"]) broken.folders.push_back(thing["folder"].Scalar());
        if (thing["fifo"]) broken.fifos.push_back(thing["fifo"].Scalar());
        if (thing["link"])
          broken.links.emplace_back(thing["link"][0].Scalar(), thing["link"][1].Scalar());
      }
    } else if (key == "run") {
      for (const auto& argument : value) broken.arguments.push_back(content(argument));
    } else if (key == "says") {
      for (const auto& line : value) broken.says.push_back(line.Scalar());
    } else {
      throw std::runtime_error(fmt::format("{}: a case has no key '{}'", group, key));
    }
  }
  if (!node["run"]) broken.arguments = {"solve", "pendulum.yaml", "-o", "out"};
  if (broken.name.empty() || broken.says.empty())
    throw std::runtime_error(fmt::format("{}: a case lacks its name or 'says'", group));
  return broken;
}

}  // namespace

void PrintTo(const BrokenCase& broken, std::ostream* stream) {
  *stream << broken.group << ": " << broken.name;
}

std::vector<BrokenCase> broken_cases() {
  std::vector<std::filesystem::path> files;
  for (const auto& entry : std::filesystem::directory_iterator(source("tests/broken")))
    if (entry.path().extension() == ".yaml") files.push_back(entry.path());
  std::sort(files.begin(), files.end());
  std::vector<BrokenCase> cases;
  for (const std::filesystem::path& file : files) {
    const YAML::Node list = YAML::LoadFile(file.string());
    for (const auto& node : list) cases.push_back(read_case(node, file.stem().string()));
  }
  return cases;
}

void write_good_inputs(const TemporaryFolder& folder) {
  for (const auto& entry : std::filesystem::directory_iterator(source("tests/broken/good")))
    folder.write(entry.path().filename().string(), read_file(entry.path()));
}

void BrokenCase::prepare(const TemporaryFolder& folder) const {
  write_good_inputs(folder);
  for (const Change& change : changes) {
    std::string text = read_file(folder.path() / change.file);
    const std::size_t at = text.find(change.from);
    if (at == std::string::npos)
      throw std::runtime_error(fmt::format("'{}' is not in {}", change.from, change.file));
    folder.write(change.file, text.replace(at, change.from.size(), change.to));
  }
  for (const auto& [file, text] : writes) folder.write(file, text);
  const auto fresh = [&](const std::string& name) {
    std::filesystem::remove(folder.path() / name);
    return folder.path() / name;
  };
  for (const std::string& name : folders) std::filesystem::create_directory(fresh(name));
  for (const std::string& name : fifos)
    if (mkfifo(fresh(name).c_str(), 0666) != 0) throw std::runtime_error("no fifo");
  for (const auto& [target, name] : links) std::filesystem::create_symlink(target, fresh(name));
}

}  // namespace conddp
