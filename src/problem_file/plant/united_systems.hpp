#pragma once

#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "problem_file/spec/spec.hpp"

namespace conddp {

/// A system of a file that phases name.
struct UsedSystem {
  const NamedSystemSpec* named;
  std::shared_ptr<const System> system;
  /// Of equations, with the states of all systems.
  std::optional<ExpressionSystemText> text = {};
};

/// The systems that phases name, in the order of the phases, all with the same columns of the
/// state: where they have different ones, these are all of them in the order in which they first
/// appear, and a system rests in those that it lacks. Empty, and reported, where systems do not fit
/// each other: of another kind or with other units, or other states of systems that are not of
/// first order or of differences.
std::vector<UsedSystem> unite_systems(const ProblemSpec& spec, Diagnostics& out);

/// The controls of all of them, in the order in which they first appear.
std::vector<Column> controls_of(const std::vector<UsedSystem>& systems);

/// Whether two systems have the same states and the same controls.
bool have_same_columns(const System& a, const System& b);

}  // namespace conddp
