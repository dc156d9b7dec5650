#pragma once

#include <optional>
#include <string>
#include <vector>

#include "base/text/name_pattern.hpp"
#include "problem_file/spec/spec_values.hpp"
#include "systems/system.hpp"

namespace conddp {

/// What the components of a vector are called in a problem file.
struct ComponentNames {
  std::string what;                 ///< in messages: "joints", "columns of the state"
  std::vector<std::string> names;   ///< full names
  std::vector<std::string> second;  ///< other names accepted, empty where there is none
  /// Components that only their own names mean: one number for all, lists and names with `*` leave
  /// them out. Empty where there are none.
  std::vector<bool> by_name_only = {};
  /// Names of components that other phases have: what is given for them counts there alone.
  std::vector<std::string> elsewhere = {};

  ComponentNames() = default;
  ComponentNames(std::string what_they_are, std::vector<std::string> full_names);
  int size() const { return static_cast<int>(names.size()); }
  bool is_listed(std::size_t i) const { return by_name_only.empty() || !by_name_only[i]; }
  /// Those that lists have.
  ComponentNames listed() const;
};

/// One number a component; components without one get `fallback`. A wrong length or an unknown name
/// is reported. Of several names that fit, an exact one wins over one with `*`, a longer over a
/// shorter one.
std::optional<std::vector<double>> resolve(const ComponentsSpec& spec, const ComponentNames& names,
                                           double fallback, Diagnostics& out);
/// The same of what a file may leave out: then every component gets `fallback`.
std::optional<std::vector<double>> resolve(const std::optional<ComponentsSpec>& spec,
                                           const ComponentNames& names, double fallback,
                                           Diagnostics& out);

/// "joints: a, b, c", for hints.
std::string list_of(const ComponentNames& names);

/// The clock of a system that depends on the time, parameters and states at rest are meant by their
/// own names only.
ComponentNames state_names(const System& system);
ComponentNames control_names(const System& system);
/// Components of tangent vectors at a state: flat columns keep their names, a pose has x, y, z and
/// rx, ry, rz (rotation vector) instead of its quaternion. As in state_names, clock, parameters and
/// states at rest are meant by their own names only.
ComponentNames tangent_names(const System& system);

}  // namespace conddp
