#include <cmath>
#include <limits>
#include <map>

#include <fmt/format.h>

#include "base/text/spelling.hpp"
#include "nlp/ipopt_options.hpp"
#include "problem_file/document/homotopy_numbers.hpp"
#include "problem_file/read/read_sections.hpp"
#include "solvers/common/option_table.hpp"

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

std::optional<IpoptValue> read_ipopt_value(const std::string& name, const YamlReader& reader) {
  if (!reader.is_number()) {
    auto text = reader.text();
    if (!text) return std::nullopt;
    return IpoptValue(*std::move(text));
  }
  const auto number = reader.number();
  if (!number) return std::nullopt;
  const bool whole = *number == std::floor(*number) && std::abs(*number) < 2e9;
  if (whole && is_integer_option(name)) return IpoptValue(static_cast<int>(*number));
  return IpoptValue(*number);
}

std::string shown(const IpoptValue& value) {
  return std::visit([](const auto& v) { return fmt::format("{}", v); }, value);
}

/// The library checks names, types and ranges, and which options its build supports.
void read_ipopt_options(const YamlReader& reader, IpoptOptions& options) {
  const auto entries = reader.named_entries();
  if (!entries) return;
  std::vector<const YamlReader*> readers;
  for (const auto& [name, value] : *entries) {
    auto read = read_ipopt_value(name.value, value);
    if (!read) continue;
    const auto fault = check_ipopt_option(name.value, *read);
    if (!fault) {
      options.emplace_back(name.value, *std::move(read));
      readers.push_back(&value);
    } else if (fault->kind == IpoptOptionFault::Kind::value) {
      value.error(fault->message);
    } else {
      reader.diagnostics().error(
          name.place, fault->message,
          fault->kind == IpoptOptionFault::Kind::unknown
              ? name_hint(name.value, ipopt_option_names(), "options of Ipopt")
              : "");
    }
  }
  if (const auto unusable = first_unusable_ipopt_option(options)) {
    const auto& [name, value] = options[*unusable];
    readers[*unusable]->error(
        fmt::format("this machine's Ipopt cannot use '{}' as '{}'", shown(value), name),
        "it was built without it, or needs more than conddp tells it");
  }
}

/// Reads an option under its former name.
void read_former(YamlMap& map, const OptionInfo& info, SolverOptions& options) {
  const auto reader = map.find(info.formerly);
  if (!reader) return;
  reader->diagnostics().note(reader->place(),
                             fmt::format("'{}' is now called '{}'", info.formerly, info.name));
  read_option(*reader, info, options);
}

/// Reads an option under its present or former name.
void read_plain_option(YamlMap& map, const OptionInfo& info, SolverOptions& options) {
  if (const auto r = map.find(info.name)) read_option(*r, info, options);
  if (!info.formerly.empty() && map.reader().node().find(std::string(info.formerly)))
    read_former(map, info, options);
}

/// Reads options by name; names with a dot are grouped in mappings.
void read_options(YamlMap& map, SolverOptions& options) {
  std::map<std::string, YamlMap> groups;
  for (const OptionInfo& info : option_table()) {
    const std::size_t dot = info.name.find('.');
    if (dot == std::string_view::npos) {
      read_plain_option(map, info, options);
      continue;
    }
    const std::string group(info.name.substr(0, dot));
    const auto r = map.find(group);
    if (!r) continue;
    YamlMap& inner = groups.try_emplace(group, *r).first->second;
    if (const auto value = inner.find(info.name.substr(dot + 1)))
      read_option(*value, info, options);
  }
  for (auto& [name, group] : groups) group.finish();
}

}  // namespace

SolverSpec read_solver(const YamlReader& reader) {
  SolverSpec solver{.place = reader.place()};
  YamlMap map(reader, "write '{name: box_fddp}'");
  if (!map.valid()) return solver;
  map.name("name", solver.name);
  read_options(map, solver.options);
  if (const auto r = map.find("options")) read_ipopt_options(*r, solver.options.ipopt);
  map.read("homotopy", solver.homotopy, read_homotopy);
  if (!reader.diagnostics().has_errors())
    for (const std::string& message : solver.options.validate()) reader.error(message);
  return solver;
}

}  // namespace conddp
