#include "output/solution/finding_report.hpp"

#include <algorithm>

#include <fmt/format.h>

#include "base/json/json_object.hpp"
#include "problem_file/residuals/rows_key.hpp"
#include "problem_file/spec/spec_expression.hpp"
#include "problem_file/terms/term_residual.hpp"

namespace conddp {
namespace {

/// Number of findings printed per kind.
constexpr int kShown = 3;

/// True if the rows of a constraint are distances of shapes.
bool is_of_shapes(const ConstraintSpec& constraint) {
  return !constraint.bounded && constraint.function.definition->needs.shapes;
}

/// True if a cost or constraint is not limited to some phases or knots.
bool holds_throughout(const CostSpec& c) { return !c.phases && !c.knots; }

/// Records a cost or constraint on friction cones (or wrench cones, which contain them) by contact.
void note_cone(const ProblemSpec& spec, const CostSpec& c, bool constraint, FindingNames& names) {
  if (c.definition == nullptr ||
      (c.definition->name != "friction_cone" && c.definition->name != "wrench_cone"))
    return;
  const ContactNames chosen = c.keys.value(key::contacts);
  for (const ContactSpec& contact : spec.contacts)
    if (chosen.has(contact.name.value))
      names.cones[contact.name.value].push_back({c.name.value, constraint, holds_throughout(c)});
}

/// Records what the file already requests, so that findings need not recommend it.
void note_constraints(const ProblemSpec& spec, FindingNames& names) {
  for (const ControlBoundsSpec& c : spec.control_bounds)
    if (c.from_urdf && !c.phases) names.bounded.insert("control");
  for (const ConstraintSpec& c : spec.constraints) {
    if (!c.bounded) note_cone(spec, c.function, true, names);
    if (!holds_throughout(c.function)) continue;
    if (c.bounded && c.from_urdf) {
      const bool state = c.bounded->value == BoundedQuantity::kState;
      if (state || c.bounded->value == BoundedQuantity::kConfiguration)
        names.bounded.insert("configuration");
      if (state || c.bounded->value == BoundedQuantity::kVelocity) names.bounded.insert("velocity");
      if (c.bounded->value == BoundedQuantity::kControl) names.bounded.insert("control");
    }
  }
  for (const CostSpec& c : spec.costs) note_cone(spec, c, false, names);
}

/// Pairs of shapes, or names or numbers of rows, with their expressions if each row has one.
FindingNames::Rows rows_of(const ConstraintSpec& c, const std::vector<std::string>& names) {
  if (is_of_shapes(c)) return {names, "m"};
  const std::vector<ExpressionText> texts = c.function.keys.value(key::expression_rows).texts;
  FindingNames::Rows rows;
  for (std::size_t i = 0; i < names.size(); ++i)
    rows.names.push_back(fmt::format("row {}", names[i]) +
                         (texts.size() == names.size() ? ", " + texts[i].text : ""));
  return rows;
}

FindingNames names_of(const ProblemSpec& spec, const BuiltProblem& built) {
  FindingNames names;
  note_constraints(spec, names);
  for (const ContactSpec& contact : spec.contacts)
    names.friction[contact.name.value] = contact.friction;
  Diagnostics found_when_built;
  for (const bool terminal : {false, true})
    for (const ConstraintSpec& c : terminal ? spec.terminal_constraints : spec.constraints) {
      if (c.bounded || c.function.definition->of_contacts()) continue;
      const auto residual =
          make_cost_residual(c.function, spec, built.plant, built.problem->ndx(), found_when_built);
      if (residual && (is_of_shapes(c) || residual->rows.names.size() > 1))
        names.rows[(terminal ? "terminal/" : "") + c.function.name.value] =
            rows_of(c, residual->rows.names);
    }
  return names;
}

}  // namespace

std::vector<Finding> findings_of(const ProblemSpec& spec, const BuiltProblem& built,
                                 const Trajectory& trajectory,
                                 const std::vector<Eigen::MatrixXd>& gains,
                                 const NodeValues& values) {
  return find_in_motion(*built.problem, trajectory, gains, values, names_of(spec, built));
}

OrderedJson findings_json(const std::vector<Finding>& findings) {
  OrderedJson list = OrderedJson::array();
  for (const Finding& f : findings) {
    OrderedJson entry = json_object(8);
    entry["kind"] = to_string(f.kind);
    entry["subject"] = f.subject;
    entry["value"] = f.value;
    entry["unit"] = f.unit;
    entry["message"] = f.message;
    if (f.knot >= 0) {
      entry["knot"] = f.knot;
      entry["time_s"] = f.time;
    }
    if (!f.remedy.empty()) entry["remedy"] = f.remedy;
    list.push_back(std::move(entry));
  }
  return list;
}

namespace {

std::string line_of(const Finding& f) {
  if (f.knot < 0) return f.message;
  return f.message + fmt::format(" (knot {}, {:.3g} s)", f.knot, f.time);
}

}  // namespace

std::vector<std::string> finding_lines(const std::vector<Finding>& findings) {
  std::vector<std::string> lines;
  for (std::size_t first = 0, last = 0; first < findings.size(); first = last) {
    const auto end = std::find_if(findings.begin() + first, findings.end(),
                                  [&](const Finding& f) { return f.kind != findings[first].kind; });
    last = end - findings.begin();
    for (std::size_t i = first; i < std::min(first + kShown, last); ++i) {
      lines.push_back(line_of(findings[i]));
      if (i == first && !findings[i].remedy.empty()) lines.back() += "; try " + findings[i].remedy;
    }
    if (last > first + kShown)
      lines.push_back(fmt::format("and {} more of the kind '{}'", last - first - kShown,
                                  to_string(findings[first].kind)));
  }
  return lines;
}

}  // namespace conddp
