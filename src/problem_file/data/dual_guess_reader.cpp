#include "problem_file/data/dual_guess_reader.hpp"

#include <algorithm>
#include <cmath>
#include <map>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "base/json_document.hpp"
#include "base/solution_members.hpp"

namespace conddp {
namespace {

using Json = nlohmann::json;

/// A list of numbers; nothing where it is none, or has another length.
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

/// Fills in the multipliers of one constraint, all of its nodes or none.
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

/// Of the dynamics and of bounds on the control.
bool take_dynamics(const Json& multipliers, const ShootingProblem& problem, DualGuess& guess) {
  const int N = problem.knots();
  const Json& costates = solution_list(multipliers, "costates");
  if (static_cast<int>(costates.size()) != N + 1) return false;
  Eigen::MatrixXd lambda(problem.ndx(), N + 1);
  std::vector<Eigen::VectorXd> gradient;
  const bool bounded =
      multipliers.contains("control_lower") && multipliers.contains("control_upper");
  for (int k = 0; k <= N; ++k) {
    const auto column = numbers(costates[k], problem.ndx());
    if (!column) return false;
    lambda.col(k) = *column;
    if (k == N) break;
    gradient.push_back(Eigen::VectorXd::Zero(problem.nu(k)));
    if (!bounded) continue;
    for (const bool upper : {false, true}) {
      const Json& list = solution_list(multipliers, upper ? "control_upper" : "control_lower");
      if (static_cast<int>(list.size()) != N) return false;
      const auto row = numbers(list[k], problem.nu(k));
      if (!row) return false;
      gradient.back() += upper ? -*row : *row;
    }
  }
  guess.costates = std::move(lambda);
  guess.control_gradient = std::move(gradient);
  return true;
}

DualGuessUsed read(const Json& multipliers, const ShootingProblem& problem) {
  auto guess = std::make_shared<DualGuess>();
  guess->constraints = Eigen::VectorXd::Zero(problem.constraint_rows());
  const auto entries = entries_by_name(multipliers);
  std::vector<std::string> names, used, changed;
  std::map<std::string, std::vector<const NodeConstraint*>> constraints;
  for (const NodeConstraint& c : problem.constraints()) {
    auto& list = constraints[c.term->name];
    if (list.empty()) names.push_back(c.term->name);
    list.push_back(&c);
  }
  for (const std::string& name : names) {
    const auto found = entries.find(name);
    const bool taken =
        found != entries.end() && take(constraints[name], found->second, guess->constraints);
    (taken ? used : changed).push_back(name);
  }
  if (take_dynamics(multipliers, problem, *guess)) used.insert(used.begin(), "the dynamics");
  DualGuessUsed result;
  result.text = used.empty() ? "none" : "of " + list_names(used);
  if (!changed.empty())
    result.text += "; not of " + list_names(changed) + ", which the file has at other nodes or not";
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
