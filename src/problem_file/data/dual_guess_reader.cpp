#include "problem_file/data/dual_guess_reader.hpp"

#include <algorithm>
#include <cmath>
#include <map>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "base/json/json_document.hpp"
#include "ocp/problem/by_name.hpp"

namespace conddp {
namespace {

using Json = nlohmann::json;

/// A list of `count` finite numbers; empty for anything else.
std::optional<Eigen::VectorXd> numbers(const Json& list, Eigen::Index count) {
  if (!list.is_array() || static_cast<Eigen::Index>(list.size()) != count) return std::nullopt;
  Eigen::VectorXd values(count);
  for (Eigen::Index i = 0; i < count; ++i) {
    if (!list[i].is_number() || !std::isfinite(list[i].get<double>())) return std::nullopt;
    values[i] = list[i];
  }
  return values;
}

/// The entries of each constraint in their order, by name.
std::map<std::string, std::vector<const Json*>> entries_by_name(const Json& multipliers) {
  std::map<std::string, std::vector<const Json*>> entries;
  if (!multipliers.contains("constraints")) return entries;
  for (const Json& entry : solution_list(multipliers, "constraints"))
    entries[solution_text(entry, "name")].push_back(&entry);
  return entries;
}

/// Sets the multipliers of one constraint, for all of its nodes or none of them.
bool take(const std::vector<const NodeConstraint*>& constraint,
          const std::vector<const Json*>& entries, Eigen::VectorXd& rows) {
  if (constraint.size() != entries.size()) return false;
  std::vector<Eigen::VectorXd> found;
  for (std::size_t i = 0; i < entries.size(); ++i) {
    const auto values =
        numbers(solution_member(*entries[i], "multiplier"), constraint[i]->term->rows);
    if (!values || solution_member(*entries[i], "node") != constraint[i]->node) return false;
    found.push_back(*values);
  }
  for (std::size_t i = 0; i < found.size(); ++i)
    rows.segment(constraint[i]->row, found[i].size()) = found[i];
  return true;
}

std::string list_names(const std::vector<std::string>& names) {
  std::string list;
  for (const std::string& name : names) list += (list.empty() ? "" : ", ") + name;
  return list;
}

/// The gradient of the Lagrangian with respect to a knot's controls, from the multipliers of their
/// bounds; empty if these do not fit.
std::optional<Eigen::VectorXd> control_gradient(const Json& multipliers, int knot,
                                                const ShootingProblem& problem,
                                                const ControlColumns& columns) {
  Eigen::VectorXd gradient = Eigen::VectorXd::Zero(problem.nu(knot));
  if (!multipliers.contains("control_lower") || !multipliers.contains("control_upper"))
    return gradient;
  for (const bool upper : {false, true}) {
    const Json& list = solution_list(multipliers, upper ? "control_upper" : "control_lower");
    if (static_cast<int>(list.size()) != problem.knots()) return std::nullopt;
    const auto row = numbers(columns.own_entries(knot, list[knot]), problem.nu(knot));
    if (!row) return std::nullopt;
    gradient += upper ? -*row : *row;
  }
  return gradient;
}

/// Sets the multipliers of the dynamics and of control bounds.
bool take_dynamics(const Json& multipliers, const ShootingProblem& problem, DualGuess& guess) {
  const int N = problem.knots();
  const Json& costates = solution_list(multipliers, "costates");
  if (static_cast<int>(costates.size()) != N + 1) return false;
  const ControlColumns columns(problem);
  Eigen::MatrixXd lambda(problem.ndx(), N + 1);
  std::vector<Eigen::VectorXd> gradient;
  for (int k = 0; k <= N; ++k) {
    const auto column = numbers(costates[k], problem.ndx());
    if (!column) return false;
    lambda.col(k) = *column;
    if (k == N) break;
    auto row = control_gradient(multipliers, k, problem, columns);
    if (!row) return false;
    gradient.push_back(*std::move(row));
  }
  guess.costates = std::move(lambda);
  guess.control_gradient = std::move(gradient);
  return true;
}

/// The constraints of a problem by name, node by node, in the order of their first nodes.
std::vector<std::vector<const NodeConstraint*>> constraints_by_name(
    const ShootingProblem& problem) {
  std::vector<std::vector<const NodeConstraint*>> constraints;
  std::map<std::string, std::size_t> known;
  for (const NodeConstraint& c : problem.constraints()) {
    const std::size_t index = known.try_emplace(c.term->name, known.size()).first->second;
    if (index == constraints.size()) constraints.emplace_back();
    constraints[index].push_back(&c);
  }
  return constraints;
}

/// "of the dynamics, torque; not of grip, which ...".
std::string text_of(const std::vector<std::string>& used, const std::vector<std::string>& changed) {
  std::string text = used.empty() ? "none" : "of " + list_names(used);
  if (!changed.empty())
    text += "; not of " + list_names(changed) + ", which the file has at other nodes or lacks";
  return text;
}

DualGuessUsed read(const Json& multipliers, const ShootingProblem& problem) {
  auto guess = std::make_shared<DualGuess>();
  guess->constraints = Eigen::VectorXd::Zero(problem.constraint_rows());
  const auto entries = entries_by_name(multipliers);
  std::vector<std::string> used, changed;
  for (const auto& constraint : constraints_by_name(problem)) {
    const std::string& name = constraint.front()->term->name;
    const auto found = entries.find(name);
    const bool taken =
        found != entries.end() && take(constraint, found->second, guess->constraints);
    (taken ? used : changed).push_back(name);
  }
  if (take_dynamics(multipliers, problem, *guess)) used.insert(used.begin(), "the dynamics");
  DualGuessUsed result;
  result.text = text_of(used, changed);
  if (!used.empty()) result.guess = std::move(guess);
  return result;
}

}  // namespace

std::optional<DualGuessUsed> read_dual_guess(const std::filesystem::path& file, const Place& place,
                                             const ShootingProblem& problem, Diagnostics& out) {
  constexpr std::string_view kKeys[] = {"multipliers"};
  const auto document = load_document(file, kSolutionDocument, kKeys, place, out);
  if (!document) return std::nullopt;
  try {
    return read(solution_member(*document, "multipliers"), problem);
  } catch (const MalformedSolution& e) {
    out.add({.file = file.string(),
             .message = "the multipliers cannot be used: " + std::string(e.what())});
  }
  return std::nullopt;
}

}  // namespace conddp
