#include <algorithm>

#include <fmt/format.h>

#include "summary/summary.hpp"

namespace conddp {
namespace {

std::string comma_list(const OrderedJson& names) {
  std::string list;
  for (const auto& name : names) list += (list.empty() ? "" : ", ") + name.get<std::string>();
  return list;
}

std::string text_of(const OrderedJson& value) { return value.get<std::string>(); }

std::string formula_lines(const OrderedJson& formulas) {
  std::string text;
  for (const auto& line : formulas) text += fmt::format("  {:<18}{}\n", "", text_of(line));
  return text;
}

std::string cost_lines(const OrderedJson& costs, const char* heading) {
  std::string text;
  for (const auto& cost : costs) {
    text += fmt::format("  {:<16}{}: {}, {} rows, {}, weight {:g}", text.empty() ? heading : "",
                        text_of(cost["name"]), text_of(cost["residual"]), cost["rows"].get<int>(),
                        text_of(cost["activation"]), cost["weight"].get<double>());
    if (cost.contains("phases"))
      text += ", in " + (cost["phases"].empty() ? "no phase" : comma_list(cost["phases"]));
    text += '\n' + formula_lines(cost["formulas"]);
  }
  return text;
}

std::string step_text(const OrderedJson& phase) {
  const double longest = phase["dt_s"].get<double>(),
               shortest = phase["shortest_dt_s"].get<double>();
  if (shortest == longest) return fmt::format("{:.9g}", longest);
  return fmt::format("{:.3g} to {:.9g}", shortest, longest);
}

std::string phase_text(const OrderedJson& phase) {
  const std::string contacts = comma_list(phase["contacts"]);
  if (phase["kind"] == "choice") return "the first state is chosen";
  if (phase["kind"] == "impulse") return "an impulse at " + contacts;
  if (phase["kind"] == "jump") return "a jump of states";
  std::string text = fmt::format("{} knots of {} s, {:.9g} s", phase["knots"].get<int>(),
                                 step_text(phase), phase["duration_s"].get<double>());
  if (phase.contains("system")) text += ", system " + text_of(phase["system"]);
  if (contacts.empty()) return text;
  text += ", in contact: " + contacts;
  if (!phase["redundant_contacts"].empty())
    text += fmt::format(
        " (redundant: {} of {} rows are independent in the initial state; forces "
        "between {} are not determined)",
        phase["contact_rank"].get<int>(), phase["contact_rows"].get<int>(),
        comma_list(phase["redundant_contacts"]));
  return text;
}

std::string candidate_lines(const OrderedJson& candidates) {
  std::string text;
  for (const auto& candidate : candidates) {
    const double radius = candidate["radius_m"].get<double>();
    text += fmt::format("  {:<16}{}: a {} at {} against a {} of {}, friction {:g}\n",
                        text.empty() ? "may touch" : "", text_of(candidate["name"]),
                        radius > 0 ? fmt::format("sphere of {:g} m", radius) : "point",
                        text_of(candidate["frame"]), text_of(candidate["against"]),
                        text_of(candidate["of"]), candidate["friction"].get<double>());
  }
  return text;
}

std::string plant_lines(const OrderedJson& s) {
  if (!s["system"].is_null())
    return fmt::format("  {:<16}{}\n", "system", text_of(s["system"])) +
           formula_lines(s["formulas"]);
  std::string text;
  for (const auto& robot : s["robots"]) {
    const std::string name = text_of(robot["name"]);
    text +=
        fmt::format("  {:<16}{}{}, {} base, {} degrees of freedom\n", text.empty() ? "robots" : "",
                    name.empty() ? "" : name + ": ", text_of(robot["file"]), text_of(robot["base"]),
                    robot["degrees_of_freedom"].get<int>());
  }
  return text;
}

std::string constraint_text(const OrderedJson& constraint) {
  const std::string on = text_of(constraint["on"]), set = text_of(constraint["set"]);
  if (set == "bounds") return "bounds on " + (on == "control" ? "the control" : on);
  if (set == "norm") return "bounds on the norm of " + on;
  return (set == "cone" ? "second-order cone of " : "constraint on ") + on;
}

bool is_kept_beside_bounds(const OrderedJson& constraint) {
  const bool bounds = constraint["on"] == "control" && constraint["set"] == "bounds";
  return !bounds && !constraint["dropped"].get<bool>();
}

/// The solver's treatment of the constraints that were not dropped.
std::string kept_text(const OrderedJson& s) {
  const std::string word = text_of(s["solver"]["control_bounds"]);
  const bool further =
      std::any_of(s["constraints"].begin(), s["constraints"].end(), is_kept_beside_bounds);
  if (word == "none") return further ? "enforces the constraints" : "nothing is constrained";
  return std::string(word == "kept" ? "enforces the control bounds"
                                    : "clamps controls to their bounds") +
         (further ? (word == "kept" ? " and the constraints" : " and enforces the constraints")
                  : "");
}

/// Example: "q/0, v/0"; only the first columns of many.
std::string column_text(const OrderedJson& columns) {
  constexpr std::size_t kShown = 4;
  std::string text;
  for (std::size_t i = 0; i < std::min(kShown, columns.size()); ++i)
    text += (i > 0 ? ", " : "") + text_of(columns[i]);
  if (columns.size() > kShown) text += fmt::format(" ... {}", text_of(columns.back()));
  return text;
}

std::string phase_lines(const OrderedJson& phases) {
  std::string text;
  for (const auto& phase : phases)
    text += fmt::format("  {:<16}{}: {}\n", text.empty() ? "phases" : "", text_of(phase["name"]),
                        phase_text(phase));
  return text;
}

std::string constraint_lines(const OrderedJson& constraints) {
  std::string text;
  for (const auto& constraint : constraints) {
    const std::string soft = text_of(constraint["soft"]);
    text +=
        fmt::format("  {:<16}{}: {}{}, {}{}{}\n", text.empty() ? "constraints" : "",
                    text_of(constraint["name"]), constraint_text(constraint),
                    constraint["from_urdf"].get<bool>() ? " from the URDF" : "",
                    constraint["terminal"].get<bool>() ? "at the last node"
                                                       : "in " + comma_list(constraint["phases"]),
                    soft == "no" ? "" : "; soft: " + soft,
                    constraint["dropped"].get<bool>() ? "; dropped" : "");
    text += formula_lines(constraint["formulas"]);
  }
  return text;
}

/// The solver, and the settings around its solves.
std::string solver_lines(const OrderedJson& s) {
  const OrderedJson& solver = s["solver"];
  std::string text = fmt::format("  {:<16}{} ({}): {}\n", "solver", text_of(solver["name"]),
                                 text_of(solver["description"]), kept_text(s));
  if (!solver["then"].empty())
    text +=
        fmt::format("  {:<16}where that does not converge: {}\n", "", comma_list(solver["then"]));
  for (const auto& key : solver["homotopy"])
    text += fmt::format("  {:<16}homotopy of {} from {} to {}\n", "", text_of(key["key"]),
                        key["from"].get<double>(), key["to"].get<double>());
  if (const int restarts = solver["restarts"].get<int>(); restarts > 0)
    text += fmt::format("  {:<16}restarts: {} perturbations of the first guess\n", "", restarts);
  return text;
}

std::string loop_line(const OrderedJson& loop) {
  if (loop.is_null()) return {};
  return fmt::format("  {:<16}{:g} s, ticks of {:g} s with a horizon of {:g} s, by {}\n",
                     "closed loop", loop["duration_s"].get<double>(), loop["tick_s"].get<double>(),
                     loop["horizon_s"].get<double>(), text_of(loop["solver"]));
}

}  // namespace

std::string check_text(const OrderedJson& s) {
  std::string text = fmt::format("{}: the problem is well formed\n", text_of(s["name"]));
  text += plant_lines(s);
  text += fmt::format("  {:<16}{} numbers ({} directions), {} controls\n", "state",
                      s["state"]["numbers"].get<int>(), s["state"]["tangent"].get<int>(),
                      s["control"]["numbers"].get<int>());
  text += fmt::format("  {:<16}state: {}; control: {}\n", "columns",
                      column_text(s["state"]["columns"]), column_text(s["control"]["columns"]));
  text += fmt::format("  {:<16}{}\n", "integrator", text_of(s["integrator"]));
  text += fmt::format("  {:<16}{} knots, {:.9g} s\n", "horizon", s["knots"].get<int>(),
                      s["duration_s"].get<double>());
  text += phase_lines(s["phases"]);
  text += candidate_lines(s["contact_candidates"]);
  text += cost_lines(s["costs"], "costs");
  text += cost_lines(s["terminal_costs"], "terminal costs");
  text += constraint_lines(s["constraints"]);
  text += solver_lines(s);
  text +=
      fmt::format("  {:<16}states: {}; controls: {}\n", "first guess",
                  text_of(s["initial_guess"]["states"]), text_of(s["initial_guess"]["controls"]));
  text += loop_line(s["mpc"]);
  return text;
}

}  // namespace conddp
