#include <limits>
#include <map>

#include <fmt/format.h>

#include "problem_file/read_sections.hpp"
#include "solvers/option_table.hpp"

namespace conddp {
namespace {

constexpr double kInfinity = std::numeric_limits<double>::infinity();

void read_option(const YamlReader& reader, const OptionInfo& info, SolverOptions& options) {
  if (!info.choices.empty()) {
    std::vector<std::string> words(info.choices.begin(), info.choices.end());
    const std::string what = fmt::format("value of '{}'", info.name);
    if (const auto index = reader.choose(words, what)) info.set(options, words[*index]);
    return;
  }
  if (reader.is_null() && info.max == kInfinity && !info.max_excluded) {
    info.set(options, kInfinity);
    return;
  }
  const auto number = reader.number();
  if (!number) return;
  if (const auto wrong = info.set(options, *number)) reader.error(*wrong);
}

}  // namespace

SolverSpec read_solver(const YamlReader& reader) {
  SolverSpec solver;
  YamlMap map(reader);
  if (!map.valid()) return solver;
  if (const auto r = map.find("name")) solver.name = r->name().value_or(solver.name);
  std::map<std::string, YamlMap> groups;
  for (const OptionInfo& info : option_table()) {
    const std::size_t dot = info.name.find('.');
    if (dot == std::string_view::npos) {
      if (const auto r = map.find(info.name)) read_option(*r, info, solver.options);
      continue;
    }
    const std::string group(info.name.substr(0, dot));
    if (const auto r = map.find(group)) {
      YamlMap& inner = groups.try_emplace(group, *r).first->second;
      if (const auto value = inner.find(info.name.substr(dot + 1)))
        read_option(*value, info, solver.options);
    }
  }
  for (auto& [name, group] : groups) group.finish();
  if (!reader.diagnostics().has_errors())
    for (const std::string& message : solver.options.validate()) reader.error(message);
  return solver;
}

}  // namespace conddp
