#include "problem_file/model/components.hpp"

#include <algorithm>
#include <utility>

#include <fmt/format.h>

#include "base/text/spelling.hpp"
#include "systems/system.hpp"

namespace conddp {
namespace {

std::vector<std::string> column_names(const std::vector<Column>& columns) {
  std::vector<std::string> names;
  for (const Column& column : columns) names.push_back(column.name);
  return names;
}

std::optional<std::vector<double>> resolve_list(const ComponentsSpec& spec,
                                                const ComponentNames& names, double fallback,
                                                Diagnostics& out) {
  const int n = names.listed().size();
  if (static_cast<int>(spec.list.size()) != n) {
    out.error(spec.place,
              fmt::format("a list of {}, one for each of the {}, is expected here; this one has {}",
                          counted(n, "number"), names.what, spec.list.size()),
              list_of(names));
    return std::nullopt;
  }
  std::vector<double> values(names.names.size(), fallback);
  auto value = spec.list.begin();
  for (std::size_t i = 0; i < values.size(); ++i)
    if (names.is_listed(i)) values[i] = (value++)->value_or(fallback);
  return values;
}

void report_unknown(const Name& name, const ComponentNames& names, Diagnostics& out) {
  std::vector<std::string> accepted = names.names;
  for (const std::string& second : names.second)
    if (!second.empty()) accepted.push_back(second);
  const bool is_similar = !similar_names(name.value, accepted).empty();
  out.error(name.place, fmt::format("'{}' fits none of the {}", name.value, names.what),
            name_hint(name.value, is_similar ? accepted : names.names, names.what));
}

/// Component values by names that may fit several components. Each component takes the value of the
/// best fit.
class BestFits {
 public:
  BestFits(const ComponentNames& names, double fallback)
      : names_(names), values_(names.names.size(), fallback), best_(values_.size(), 0) {}

  /// True if the name fits any component.
  bool set(const std::string& name, double value) {
    bool found = false;
    for (std::size_t i = 0; i < values_.size(); ++i) {
      const std::size_t quality = std::max(fit(name, names_.names[i]), fit(name, names_.second[i]));
      if (quality == 0 || (is_pattern(name) && !names_.is_listed(i))) continue;
      found = true;
      if (quality < best_[i]) continue;
      best_[i] = quality;
      values_[i] = value;
    }
    return found;
  }
  const std::vector<double>& values() const { return values_; }

 private:
  const ComponentNames& names_;
  std::vector<double> values_;
  std::vector<std::size_t> best_;  ///< quality of the fit that set each value
};

/// True if a name fits components of other phases.
bool is_elsewhere(const std::string& name, const ComponentNames& names) {
  return std::any_of(names.elsewhere.begin(), names.elsewhere.end(),
                     [&](const std::string& other) { return fits(name, other); });
}

}  // namespace

ComponentNames::ComponentNames(std::string what_they_are, std::vector<std::string> full_names)
    : what(std::move(what_they_are)), names(std::move(full_names)) {
  for (const std::string& name : names)
    second.push_back(name.starts_with("q/") || name.starts_with("u/") ? name.substr(2) : "");
}

ComponentNames ComponentNames::listed() const {
  std::vector<std::string> some;
  for (std::size_t i = 0; i < names.size(); ++i)
    if (is_listed(i)) some.push_back(names[i]);
  return {what, std::move(some)};
}

std::optional<std::vector<double>> resolve(const ComponentsSpec& spec, const ComponentNames& names,
                                           double fallback, Diagnostics& out) {
  if (spec.form == ComponentsSpec::Form::kScalar) {
    std::vector<double> values(names.names.size(), fallback);
    for (std::size_t i = 0; i < values.size(); ++i)
      if (names.is_listed(i)) values[i] = spec.scalar.value_or(fallback);
    return values;
  }
  if (spec.form == ComponentsSpec::Form::kList) return resolve_list(spec, names, fallback, out);
  bool known = true;
  BestFits fits(names, fallback);
  for (const auto& [name, value] : spec.map) {
    if (fits.set(name.value, value.value_or(fallback)) || is_elsewhere(name.value, names)) continue;
    report_unknown(name, names, out);
    known = false;
  }
  if (!known) return std::nullopt;
  return fits.values();
}

std::optional<std::vector<double>> resolve(const std::optional<ComponentsSpec>& spec,
                                           const ComponentNames& names, double fallback,
                                           Diagnostics& out) {
  if (!spec) return std::vector<double>(names.names.size(), fallback);
  return resolve(*spec, names, fallback, out);
}

std::string list_of(const ComponentNames& names) {
  const ComponentNames listed = names.listed();
  std::string list;
  for (const std::string& name : listed.names) list += (list.empty() ? "" : ", ") + name;
  return names.what + ": " + list;
}

ComponentNames state_names(const System& system) {
  ComponentNames names("columns of the state", column_names(system.state_columns()));
  names.by_name_only.assign(names.names.size(), true);
  for (const int i : own_states(system)) names.by_name_only[i] = false;
  return names;
}

ComponentNames control_names(const System& system) {
  return {"controls", column_names(system.control_columns())};
}

ComponentNames tangent_names(const System& system) {
  ComponentNames result("components of the state", column_names(tangent_columns(system)));
  result.by_name_only.assign(system.ndx(), false);
  for (const int i : other_coordinates(system)) result.by_name_only[i] = true;
  return result;
}

}  // namespace conddp
