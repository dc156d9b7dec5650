#include "fuzz/targets.hpp"

#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <string>

#include "base/text/strict_number.hpp"
#include "base/text/utf8.hpp"
#include "problem_file/assemble/build.hpp"
#include "problem_file/assemble/build_problem.hpp"
#include "problem_file/data/data_table.hpp"
#include "problem_file/read/read_problem.hpp"
#include "robot/urdf/load_xml.hpp"
#include "robot/urdf/urdf.hpp"
#include "support/source_tree.hpp"
#include "systems/expressions/parser.hpp"
#include "systems/graphs/derivatives.hpp"

namespace conddp {
namespace {

/// Relative paths of problems refer to the example robots.
const std::filesystem::path kFile = source_tree() / "problems" / "fuzz.yaml";

void promise(bool kept, const char* what) {
  if (kept) return;
  std::fprintf(stderr, "broken promise: %s\n", what);
  std::abort();
}

/// Checks that every answer to a bad input has diagnostics and that they can be printed. `name` is
/// the name of the input.
void check_diagnostics(const Diagnostics& diagnostics, const std::string& name, bool good) {
  promise(good != diagnostics.has_errors(), "there is a result if and only if there is no error");
  for (const Diagnostic& d : diagnostics.list()) {
    promise(!d.message.empty(), "a diagnostic has a message");
    promise(find_bad_character(d.message + d.hint) == std::string::npos,
            "a message is text without control characters");
    promise((d.line > 0) == (d.column > 0), "line and column come together");
    if (d.line <= 0 || d.file != name) continue;
    const std::string line = diagnostics.source_line(d);
    promise(d.column <= count_characters(line) + 1, "a column lies in its line");
  }
  promise(good || !format_diagnostics(diagnostics, false).empty(), "errors are printed");
}

/// The tool checks a file before the parsers do.
bool is_text(std::string_view input) { return find_bad_character(input) == std::string::npos; }

void build_if_small(const ProblemSpec& spec, Diagnostics& out) {
  constexpr int kManyKnots = 500;
  int knots = 0;
  for (const PhaseSpec& phase : spec.phases) knots += phase.knots.value;
  if (knots > kManyKnots) return;
  const auto built = build_problem(spec, {}, out);
  check_diagnostics(out, kFile.string(), built.has_value());
}

void read_problem_input(const std::string& text, const std::vector<std::string>& settings) {
  Diagnostics out;
  const auto spec = read_problem_text(text, kFile, settings, out);
  check_diagnostics(out, settings.empty() ? kFile.string() : "--set", spec.has_value());
  if (spec) build_if_small(*spec, out);
}

void fuzz_problem(std::string_view input) {
  if (is_text(input)) read_problem_input(std::string(input), {});
}

constexpr const char* kOverridden = R"(conddp: 1
system: {type: pendulum}
initial_state: {values: {theta: 0.1}}
phases: [{name: first, knots: 4, dt: 0.1}, {name: second, knots: 6, dt: 0.05}]
costs: {effort: {residual: control, weight: 0.5}}
constraints: {torque: {bounds: control, lower: -3, upper: 3}}
terminal: {costs: {goal: {residual: state, reference: {values: {theta: 1}}, weight: 10}}}
solver: {name: box_ddp}
)";

void fuzz_override(std::string_view input) {
  read_problem_input(kOverridden, {std::string(input)});
}

void fuzz_urdf(std::string_view input) {
  UrdfOptions options;
  options.base = input.size() % 2 == 0 ? UrdfOptions::Base::fixed : UrdfOptions::Base::floating;
  options.enforce_mimic = input.size() % 3 == 0;
  const UrdfResult result = parse_urdf(input, "fuzz.urdf", options);
  bool errors = false;
  for (const UrdfProblem& problem : result.problems) {
    errors |= !problem.warning;
    promise(!problem.message.empty(), "a problem has a message");
    promise((problem.line > 0) == (problem.column > 0), "line and column come together");
  }
  promise(errors != result.model.has_value(), "there is a model if and only if there is no error");
  if (!result.model) return;
  for (const Joint& joint : result.model->joints)
    promise(std::isfinite(joint.inertia.mass), "masses are finite");
}

void fuzz_csv(std::string_view input) {
  if (!is_text(input)) return;
  Diagnostics out;
  const auto table = parse_csv(std::string(input), "fuzz.csv", out);
  check_diagnostics(out, "fuzz.csv", table.has_value());
  if (!table) return;
  promise(table->times.size() == table->rows.size(), "every row has a time");
  for (const auto& row : table->rows)
    promise(row.size() == table->columns.size(), "every row has a cell in each column");
}

void fuzz_solution(std::string_view input) {
  if (!is_text(input)) return;
  Diagnostics out;
  const auto table = parse_solution(std::string(input), "fuzz.json", out);
  check_diagnostics(out, "fuzz.json", table.has_value());
  if (!table) return;
  promise(table->times.size() == table->rows.size(), "every row has a time");
  for (const auto& row : table->rows)
    promise(row.size() == table->columns.size(), "every row has a cell in each column");
}

void fuzz_number(std::string_view input) {
  const ParsedNumber number = parse_number(input);
  promise(number.value.has_value() == number.defect.empty(), "a number or a defect");
  if (!number.value) return;
  promise(std::isfinite(*number.value), "numbers are finite");
  promise(*number.value == std::strtod(std::string(input).c_str(), nullptr),
          "numbers mean what the C library reads");
}

/// Checks the elements of a document that was read.
class PlaceCheck : public pugi::xml_tree_walker {
 public:
  explicit PlaceCheck(std::string_view text) : text_(text) {}
  bool for_each(pugi::xml_node& node) override {
    if (node.type() != pugi::node_element) return true;
    promise(depth() < 64, "elements are not nested deeply");
    promise(node.offset_debug() > previous_, "elements come in the order of their places");
    previous_ = node.offset_debug();
    promise(text_.substr(previous_ - 1).starts_with(std::string("<") + node.name()),
            "an element is at its place");
    return true;
  }

 private:
  std::string_view text_;
  std::ptrdiff_t previous_ = 0;
};

void fuzz_xml(std::string_view input) {
  if (!is_text(input)) return;
  pugi::xml_document document;
  if (const auto defect = load_xml(input, document)) {
    promise(!defect->message.empty() && find_bad_character(defect->message) == std::string::npos,
            "a defect has a message without control characters");
    // A text that ends too early has its defect behind the end.
    return promise(defect->offset <= input.size() + 1, "a defect is in the text");
  }
  PlaceCheck places(input);
  document.traverse(places);
}

/// Two scalars, a vector with parts, a quaternion, and tables of one and two arguments.
ExpressionScope fuzz_scope(ExpressionGraph& graph) {
  ExpressionScope scope;
  int inputs = 0;
  const auto add = [&](const char* name, int count, std::vector<ExpressionValue::Part> parts) {
    ExpressionValue value = ExpressionValue::vector({});
    for (int i = 0; i < count; ++i) value.nodes.push_back(graph.input(inputs++));
    if (count == 1) value.kind = ExpressionValue::Kind::kNumber;
    value.parts = std::move(parts);
    scope.add(name, value);
  };
  add("x", 1, {});
  add("y", 1, {});
  add("q", 3, {{"left-knee", 0}, {"arm/elbow", 1}, {"both", 0, 2}});
  add("r", 4, {});
  const std::vector<double> points{0, 1, 2};
  scope.add_table("drag", graph.add_table(std::make_shared<SplineTable>(points, points)), 1);
  scope.add_table("map",
                  graph.add_table(std::make_shared<SplineTable>(
                      points, std::vector<double>{0, 1}, std::vector<double>{0, 1, 2, 3, 4, 5})),
                  2);
  return scope;
}

void fuzz_expression(std::string_view input) {
  constexpr int kInputs = 9;
  ExpressionGraph graph;
  const ExpressionScope scope = fuzz_scope(graph);
  const ParsedExpression parsed = parse_expression(input, scope, graph);
  const auto has_place = [&](const ExpressionMessage& message) {
    return message.offset >= 0 && message.offset <= static_cast<int>(input.size()) &&
           !message.message.empty() &&
           find_bad_character(message.message + message.hint) == std::string::npos;
  };
  for (const ExpressionMessage& warning : parsed.warnings)
    promise(has_place(warning), "a warning has a place and a message");
  if (!parsed.value) return promise(has_place(parsed.error), "an error has a place and a message");
  promise(parsed.error.message.empty(), "there is no value beside an error");
  promise(!parsed.value->nodes.empty(), "a value has numbers");
  InputMotions motions;
  for (int i = 0; i < kInputs; ++i) motions.push_back({{i, graph.constant(1)}});
  if (count_derivatives(graph, parsed.value->nodes, motions) > kMostDerivatives) return;
  const DifferentiableExpressions functions(graph, parsed.value->nodes, kInputs, motions);
  const ExpressionProgram &alone = functions.values(), &both = functions.with_derivatives();
  std::vector<double> a(alone.registers(), 0.7), b(both.registers(), 0.7);
  alone.prepare(a.data());
  both.prepare(b.data());
  alone.run(a.data());
  both.run(b.data());
  for (int i = 0; i < functions.size(); ++i) {
    const double one = a[alone.output(i)], other = b[both.output(i)];
    promise(one == other || (std::isnan(one) && std::isnan(other)),
            "values alone are those with derivatives");
  }
}

constexpr FuzzTarget kTargets[] = {
    {"problem", fuzz_problem}, {"override", fuzz_override},     {"urdf", fuzz_urdf},
    {"csv", fuzz_csv},         {"solution", fuzz_solution},     {"number", fuzz_number},
    {"xml", fuzz_xml},         {"expression", fuzz_expression},
};

}  // namespace

std::span<const FuzzTarget> fuzz_targets() { return kTargets; }

}  // namespace conddp
