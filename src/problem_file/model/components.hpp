#pragma once

#include <optional>
#include <string>
#include <vector>

#include "base/text/spelling.hpp"
#include "problem_file/model/spec_values.hpp"
#include "systems/system.hpp"

namespace conddp {

/// Names of the components of a vector in a problem file.
struct ComponentNames {
  std::string what;                 ///< in messages: "joints", "columns of the state"
  std::vector<std::string> names;   ///< full names
  std::vector<std::string> second;  ///< synonyms; an empty string if a name has no synonym
  /// True for components that only their own names select: one number for all, lists and names with
  /// `*` skip them. Empty if all components are listed.
  std::vector<bool> by_name_only = {};
  /// Names of components that only other phases have. Values given for them apply in those phases.
  std::vector<std::string> elsewhere = {};

  ComponentNames() = default;
  ComponentNames(std::string what_they_are, std::vector<std::string> full_names);
  int size() const { return static_cast<int>(names.size()); }
  bool is_listed(std::size_t i) const { return by_name_only.empty() || !by_name_only[i]; }
  /// The components that lists contain.
  ComponentNames listed() const;
};

/// One number per component; components without one get `fallback`. A wrong length or an unknown
/// name is reported. If several names fit, an exact one wins over one with `*`, and a longer one
/// over a shorter one.
std::optional<std::vector<double>> resolve(const ComponentsSpec& spec, const ComponentNames& names,
                                           double fallback, Diagnostics& out);
/// The same for an optional key: every component gets `fallback` if the key is missing.
std::optional<std::vector<double>> resolve(const std::optional<ComponentsSpec>& spec,
                                           const ComponentNames& names, double fallback,
                                           Diagnostics& out);

/// "joints: a, b, c", for hints.
std::string list_of(const ComponentNames& names);

/// Names of the columns of the state. The clock of a time-dependent system, parameters and states
/// at rest are selected by their own names only.
ComponentNames state_names(const System& system);
ComponentNames control_names(const System& system);
/// Names of tangent components at a state. Flat columns keep their names; a pose has x, y, z and
/// rx, ry, rz (rotation vector) instead of its quaternion. As in state_names, clock, parameters and
/// states at rest are selected by their own names only.
ComponentNames tangent_names(const System& system);

}  // namespace conddp
