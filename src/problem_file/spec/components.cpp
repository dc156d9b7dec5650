#include "problem_file/spec/components.hpp"

#include <utility>

#include <fnmatch.h>

#include <fmt/format.h>

#include "base/spelling.hpp"

namespace conddp {
namespace {

std::vector<std::string> column_names(const std::vector<Column>& columns) {
  std::vector<std::string> names;
  for (const Column& column : columns) names.push_back(column.name);
  return names;
}

}  // namespace

ComponentNames::ComponentNames(std::string what_they_are, std::vector<std::string> full_names)
    : what(std::move(what_they_are)), names(std::move(full_names)) {
  for (const std::string& name : names)
    second.push_back(name.starts_with("q/") || name.starts_with("u/") ? name.substr(2) : "");
}

std::optional<std::vector<double>> resolve(const ComponentsSpec& spec, const ComponentNames& names,
                                           double fallback, Diagnostics& out) {
  const std::size_t n = names.names.size();
  if (spec.form == ComponentsSpec::Form::kScalar)
    return std::vector<double>(n, spec.scalar.value_or(fallback));
  std::vector<double> values(n, fallback);
  if (spec.form == ComponentsSpec::Form::kList) {
    if (spec.list.size() != n) {
      out.error(
          spec.place,
          fmt::format("{} numbers are expected here, one for each of the {}; this list has {}", n,
                      names.what, spec.list.size()),
          list_of(names));
      return std::nullopt;
    }
    for (std::size_t i = 0; i < n; ++i) values[i] = spec.list[i].value_or(fallback);
    return values;
  }
  bool known = true;
  std::vector<std::size_t> best(n, 0);
  for (const auto& [name, value] : spec.map) {
    bool found = false;
    for (std::size_t i = 0; i < n; ++i) {
      const std::size_t quality =
          std::max(fit(name.value, names.names[i]), fit(name.value, names.second[i]));
      if (quality == 0) continue;
      found = true;
      if (quality < best[i]) continue;
      best[i] = quality;
      values[i] = value.value_or(fallback);
    }
    if (!found) {
      std::vector<std::string> accepted = names.names;
      for (const std::string& second : names.second)
        if (!second.empty()) accepted.push_back(second);
      out.error(name.place, fmt::format("'{}' fits none of the {}", name.value, names.what),
                similar_names(name.value, accepted).empty()
                    ? name_hint(name.value, names.names, names.what)
                    : name_hint(name.value, accepted, names.what));
      known = false;
    }
  }
  if (!known) return std::nullopt;
  return values;
}

std::size_t fit(const std::string& pattern, const std::string& name) {
  if (name.empty()) return 0;
  if (pattern == name) return std::string::npos;
  if (!is_pattern(pattern)) return 0;
  return fnmatch(pattern.c_str(), name.c_str(), FNM_NOESCAPE) == 0 ? pattern.size() : 0;
}

bool fits(const std::string& pattern, const std::string& name) { return fit(pattern, name) > 0; }

bool is_pattern(const std::string& name) { return name.find('*') != std::string::npos; }

std::string list_of(const ComponentNames& names) {
  std::string list;
  for (const std::string& name : names.names) list += (list.empty() ? "" : ", ") + name;
  return names.what + ": " + list;
}

ComponentNames state_names(const System& system) {
  return {"columns of the state", column_names(system.state_columns())};
}

ComponentNames control_names(const System& system) {
  return {"controls", column_names(system.control_columns())};
}

ComponentNames tangent_names(const System& system) {
  std::vector<std::string> names(system.ndx());
  const auto& columns = system.state_columns();
  for (const auto& segment : system.manifold().segments()) {
    const bool pose = segment.part == StateManifold::Part::se3;
    if (segment.part == StateManifold::Part::flat || pose)
      for (int i = 0; i < (pose ? 3 : segment.n); ++i)
        names[segment.dx + i] = columns[segment.x + i].name;
    if (segment.part == StateManifold::Part::flat) continue;
    for (int i = 0; i < 3; ++i) {
      std::string name = columns[segment.x + (pose ? 3 : 0) + i].name;  // ".../qx"
      const std::size_t q = name.rfind('q');
      if (q != std::string::npos) name[q] = 'r';
      names[segment.dx + (pose ? 3 : 0) + i] = std::move(name);
    }
  }
  return {"components of the state", std::move(names)};
}

}  // namespace conddp
