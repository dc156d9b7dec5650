#include "output/report/report.hpp"

#include <cmath>
#include <limits>
#include <stdexcept>

#include <fmt/format.h>

#include "base/json/json_document.hpp"
#include "ocp/problem/by_name.hpp"
#include "output/report/constraint_curves.hpp"
#include "output/scene/found_contacts.hpp"
#include "output/scene/motion_scene.hpp"
#include "output/solution/solution_json.hpp"

namespace conddp {
namespace {

OrderedJson rounded(const OrderedJson& value) {
  if (value.is_number_float()) return eight_digits(value.get<double>());
  if (!value.is_array() && !value.is_object()) return value;
  OrderedJson copy = value;
  for (OrderedJson& part : copy) part = rounded(part);
  return copy;
}

double number(const OrderedJson& value) {
  return value.is_number() ? value.get<double>() : std::nan("");
}

/// Converts rows to one list per column; missing entries of shorter rows (no control) are null.
OrderedJson by_columns(const OrderedJson& rows, std::size_t columns) {
  OrderedJson lists = OrderedJson::array();
  for (std::size_t c = 0; c < columns; ++c) {
    OrderedJson list = OrderedJson::array();
    for (const OrderedJson& row : rows)
      list.push_back(c < row.size() ? rounded(row[c]) : OrderedJson(nullptr));
    lists.push_back(std::move(list));
  }
  return lists;
}

/// True if the controls of a knot set the initial state.
bool is_choice(const ShootingProblem& problem, int k) {
  return problem.phases()[problem.knot(k).phase].instant;
}

/// Control bounds per column and knot, null if unbounded.
OrderedJson bounds_json(const ShootingProblem& problem, std::size_t columns, bool upper) {
  const ControlColumns controls(problem);
  OrderedJson rows = OrderedJson::array();
  for (int k = 0; k < problem.knots(); ++k) {
    const KnotModel& model = *problem.knot(k).model;
    const auto& bounds = upper ? model.control_upper() : model.control_lower();
    OrderedJson& row = rows.emplace_back(OrderedJson::array());
    if (is_choice(problem, k)) continue;
    for (const double bound :
         controls.row(k, Eigen::Map<const Eigen::VectorXd>(bounds.data(), model.nu())))
      row.push_back(eight_digits(bound));
  }
  return by_columns(rows, columns);
}

/// Largest absolute number in nested lists.
double largest_entry(const OrderedJson& value) {
  if (!value.is_array()) return std::abs(number(value));
  double largest = 0;
  for (const OrderedJson& part : value) largest = std::fmax(largest, largest_entry(part));
  return largest;
}

/// Largest absolute number in each part of a list.
OrderedJson largest_entries(const OrderedJson& list) {
  OrderedJson norms = OrderedJson::array();
  for (const OrderedJson& part : list)
    norms.push_back(part.empty() ? OrderedJson(nullptr) : eight_digits(largest_entry(part)));
  return norms;
}

/// The largest multiplier of each constraint at each node, null if absent; names of the last node
/// begin with "terminal/".
OrderedJson multipliers_by_name(const OrderedJson& constraints, std::size_t nodes) {
  OrderedJson curves = OrderedJson::object();
  for (const OrderedJson& constraint : constraints) {
    const auto node = constraint["node"].get<std::size_t>();
    std::string name = constraint["name"].get<std::string>();
    if (node + 1 == nodes) name = "terminal/" + name;
    if (!curves.contains(name)) curves[name] = OrderedJson(nodes, nullptr);
    OrderedJson& here = curves[name][node];
    const double largest = largest_entry(constraint["multiplier"]);
    here = eight_digits(here.is_null() ? largest : std::fmax(here.get<double>(), largest));
  }
  return curves;
}

void add_multipliers(const OrderedJson& multipliers, std::size_t nodes, std::size_t controls,
                     OrderedJson& json) {
  json["costates"] = largest_entries(multipliers["costates"]);
  if (multipliers.contains("constraints"))
    json["constraint_multipliers"] = multipliers_by_name(multipliers["constraints"], nodes);
  for (const char* side : {"control_lower", "control_upper"})
    if (multipliers.contains(side))
      json["u"][fmt::format("{}_multipliers", side)] = by_columns(multipliers[side], controls);
}

OrderedJson curves_json(const OrderedJson& document) {
  const OrderedJson& trajectory = document["trajectory"];
  const OrderedJson& names = trajectory["columns"];
  OrderedJson json = {{"t", trajectory["t"]}, {"phases", trajectory["phases"]}};
  for (const char* of : {"x", "u"})
    json[of] = {{"names", names[of]},
                {"units", trajectory["units"][of]},
                {"values", by_columns(trajectory[of], names[of].size())}};
  json["contact_forces"] = rounded(trajectory.value("contact_forces", OrderedJson::object()));
  if (document.contains("gains")) json["gain"] = largest_entries(document["gains"]["K"]);
  if (document.contains("multipliers"))
    add_multipliers(document["multipliers"], trajectory["t"].size(), names["u"].size(), json);
  return json;
}

/// Parts of a solution that are shown unchanged.
OrderedJson head_json(const OrderedJson& document) {
  OrderedJson head = OrderedJson::object();
  for (const auto& [key, value] : document.items())
    if (key != "trajectory" && key != "gains" && key != "multipliers" && key != "nulls")
      head[key] = value;
  return head;
}

OrderedJson costs_json(const ShootingProblem& problem, const Trajectory& trajectory) {
  OrderedJson costs = OrderedJson::object();
  for (const auto& [name, values] : costs_by_node(problem, NodeValues(problem, trajectory))) {
    costs[name] = OrderedJson::array();
    for (const double value : values) costs[name].push_back(eight_digits(value));
  }
  return costs;
}

OrderedJson entry_json(const ReportEntry& entry) {
  OrderedJson json = {{"label", entry.label},
                      {"remark", entry.remark},
                      {"head", head_json(entry.document)},
                      {"curves", curves_json(entry.document)},
                      {"scene", nullptr}};
  if (entry.built == nullptr) return json;
  const ShootingProblem& problem = *entry.built->problem;
  Trajectory trajectory = stored_trajectory(entry.document, problem);
  OrderedJson& u = json["curves"]["u"];
  if (is_choice(problem, 0)) {
    // The motion begins with the initial state after its choice.
    for (OrderedJson& values : u["values"]) values[0] = nullptr;
    for (OrderedJson& values : json["curves"]["x"]["values"]) values[0] = values[1];
    trajectory.x(0) = trajectory.x(1);
  }
  u["lower"] = bounds_json(problem, u["names"].size(), false);
  u["upper"] = bounds_json(problem, u["names"].size(), true);
  json["curves"]["costs"] = costs_json(problem, trajectory);
  json["curves"]["constraints"] = constraint_curves(*entry.built, trajectory);
  json["scene"] = motion_scene(*entry.built, trajectory);
  if (const auto motion = contact_motion(problem, trajectory)) {
    FoundContacts found = found_contacts(*motion);
    json["scene"]["contacts"] = std::move(found.contacts);
    json["curves"]["contact_forces"] = std::move(found.forces);
  }
  return json;
}

/// A member that must be a list with `size` entries.
const OrderedJson& list_of(const OrderedJson& object, const char* key, std::size_t size) {
  const OrderedJson& list = solution_list(object, key);
  if (list.size() != size)
    throw MalformedSolution{fmt::format("'{}' should have {} entries", key, size)};
  return list;
}

/// Checks that a member is a list of objects.
void check_objects(const OrderedJson& object, const char* key) {
  for (const OrderedJson& entry : solution_list(object, key))
    if (!entry.is_object())
      throw MalformedSolution{fmt::format("'{}' has an entry that is not an object", key)};
}

void check_multipliers(const OrderedJson& multipliers, std::size_t nodes) {
  solution_list(multipliers, "costates");
  if (!multipliers.contains("constraints")) return;
  for (const OrderedJson& constraint : solution_list(multipliers, "constraints")) {
    solution_text(constraint, "name");
    solution_list(constraint, "multiplier");
    const OrderedJson& node = solution_member(constraint, "node");
    if (!node.is_number_unsigned() || node.get<std::size_t>() >= nodes)
      throw MalformedSolution{"a multiplier belongs to no node of its trajectory"};
  }
}

void check_trajectory(const OrderedJson& trajectory) {
  const std::size_t nodes = solution_list(trajectory, "t").size();
  if (nodes < 2) throw MalformedSolution{"its trajectory has no knots"};
  for (const OrderedJson& t : trajectory["t"])
    if (!t.is_number()) throw MalformedSolution{"'t' has an entry that is not a number"};
  list_of(trajectory, "x", nodes);
  list_of(trajectory, "u", nodes - 1);
  for (const char* of : {"x", "u"}) {
    const std::size_t columns = solution_list(solution_member(trajectory, "columns"), of).size();
    list_of(solution_member(trajectory, "units"), of, columns);
    for (const OrderedJson& row : trajectory[of])
      if (!row.is_array())
        throw MalformedSolution{fmt::format("'{}' has an entry that is not a list", of)};
  }
}

void check_phase(const OrderedJson& phase, std::size_t nodes) {
  solution_text(phase, "name");
  const OrderedJson& first = solution_member(phase, "first_knot");
  const OrderedJson& knots = solution_member(phase, "knots");
  if (!first.is_number_unsigned() || !knots.is_number_unsigned() ||
      first.get<std::size_t>() + knots.get<std::size_t>() >= nodes)
    throw MalformedSolution{"a phase lies outside of its trajectory"};
}

}  // namespace

void check_report_document(const OrderedJson& document) {
  for (const char* key : {"solver", "status", "message"}) solution_text(document, key);
  const OrderedJson& problem = solution_member(document, "problem");
  solution_text(problem, "name");
  for (const char* key : {"residuals", "time_s", "tool", "initial_guess_used"})
    if (!solution_member(document, key).is_object())
      throw MalformedSolution{fmt::format("'{}' is not an object", key)};
  solution_member(document, "iterations");
  const OrderedJson& trajectory = solution_member(document, "trajectory");
  check_trajectory(trajectory);
  const std::size_t nodes = trajectory["t"].size();
  for (const OrderedJson& phase : solution_list(trajectory, "phases")) check_phase(phase, nodes);
  if (document.contains("gains")) solution_list(document["gains"], "K");
  if (document.contains("multipliers")) check_multipliers(document["multipliers"], nodes);
  check_objects(document, "log");
  if (document.contains("findings")) check_objects(document, "findings");
  if (document.contains("certificate")) check_objects(document["certificate"], "checks");
}

OrderedJson report_data(const std::vector<ReportEntry>& entries) {
  OrderedJson solutions = OrderedJson::array();
  for (const ReportEntry& entry : entries) solutions.push_back(entry_json(entry));
  return {{"format", "conddp.report/1"}, {"solutions", std::move(solutions)}};
}

std::string report_page(const std::string& page, const OrderedJson& data) {
  // Pure ASCII with escapes for '<', '>' and '&': no text of the data can be parsed as a tag.
  const std::string text = data.dump(-1, ' ', true, OrderedJson::error_handler_t::replace);
  std::string safe;
  safe.reserve(text.size());
  for (const char c : text) {
    if (c == '<' || c == '>' || c == '&')
      safe += fmt::format("\\u{:04x}", static_cast<unsigned>(c));
    else
      safe += c;
  }
  const std::size_t at = page.find(kReportPlaceholder);
  if (at == page.npos) throw std::logic_error("the page of reports has no place for the data");
  std::string result = page;
  return result.replace(at, std::string_view(kReportPlaceholder).size(), safe);
}

}  // namespace conddp
