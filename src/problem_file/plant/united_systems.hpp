#pragma once

#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "problem_file/model/spec.hpp"

namespace conddp {

/// A system of the file that phases use.
struct UsedSystem {
  const NamedSystemSpec* named;
  std::shared_ptr<const System> system;
  /// Equations with the states of all systems.
  std::optional<ExpressionSystemText> text = {};
};

/// The systems that phases name, in the order of the phases, all with the same state columns. If
/// their states differ, each gets the union of all states in order of first appearance; states that
/// a system lacks are at rest in it. Returns an empty list with an error for incompatible systems:
/// different kinds, different units, or different states in systems other than first-order and
/// discrete ones.
std::vector<UsedSystem> unite_systems(const ProblemSpec& spec, Diagnostics& out);

/// The controls of all systems, in order of first appearance.
std::vector<Column> controls_of(const std::vector<UsedSystem>& systems);

/// True if two systems have the same states and the same controls.
bool have_same_columns(const System& a, const System& b);

}  // namespace conddp
