#include <algorithm>
#include <array>

#include <fmt/format.h>

#include "base/text/spelling.hpp"
#include "problem_file/model/enum_names.hpp"
#include "problem_file/model/system_fields.hpp"
#include "problem_file/read/read_sections.hpp"

namespace conddp {
namespace {

/// Maximum number of rows and columns of a matrix.
constexpr std::size_t kLargest = 1000;

/// A matrix by its rows.
struct MatrixForm {
  bool read(const YamlReader& reader, Eigen::MatrixXd& matrix) const {
    const auto rows = reader.items();
    if (!rows) return false;
    if (rows->size() > kLargest)
      return reader.error(fmt::format("a matrix has at most {} rows", kLargest)), false;
    for (std::size_t i = 0; i < rows->size(); ++i)
      if (!read_row((*rows)[i], i, rows->size(), matrix)) return matrix.resize(0, 0), false;
    if (matrix.size() == 0) return reader.error("the matrix is empty"), false;
    return true;
  }
  std::optional<OrderedJson> expand(const Eigen::MatrixXd& matrix) const {
    OrderedJson rows = OrderedJson::array();
    for (Eigen::Index i = 0; i < matrix.rows(); ++i) {
      const Eigen::RowVectorXd row = matrix.row(i);
      rows.push_back(std::vector<double>(row.begin(), row.end()));
    }
    return rows;
  }
  OrderedJson schema() const { return {{"type", "array"}, {"items", NumbersForm().schema()}}; }

 private:
  static bool read_row(const YamlReader& reader, std::size_t i, std::size_t count,
                       Eigen::MatrixXd& matrix) {
    const auto row = reader.numbers();
    if (!row) return false;
    if (row->size() > kLargest)
      return reader.error(fmt::format("a matrix has at most {} columns", kLargest)), false;
    if (i == 0) matrix.resize(count, row->size());
    const auto columns = static_cast<std::size_t>(matrix.cols());
    if (row->size() != columns)
      return reader.error(fmt::format("this row has {}, the first one has {}",
                                      counted(row->size(), "number"), columns)),
             false;
    matrix.row(i) = Eigen::Map<const Eigen::RowVectorXd>(row->data(), row->size());
    return true;
  }
};

void read_offset(const YamlReader& reader, LinearSpec& p) {
  if (p.A.size() == 0) return;
  if (const auto n = reader.numbers(p.A.rows(), "one per row of A"))
    p.c = Eigen::Map<const Eigen::VectorXd>(n->data(), n->size());
}

/// A is square, B has as many rows, and c is zero by default.
void complete(YamlMap& map, LinearSpec& p) {
  if (p.A.size() == 0 || p.B.size() == 0) return;
  if (p.A.rows() != p.A.cols())
    return map.find("A")->error(fmt::format("A is {} x {}, not square", p.A.rows(), p.A.cols()));
  if (p.B.rows() != p.A.rows())
    return map.find("B")->error(fmt::format("B has {} rows and A has {}", p.B.rows(), p.A.rows()));
  if (p.c.size() == 0) p.c = Eigen::VectorXd::Zero(p.A.rows());
}

void describe_parameters(Keys& keys, DoubleIntegratorSpec& p) {
  keys({"dimension", "Number of independent axes"}, p.dimension, IntegerForm{1, 1000});
}

void describe_parameters(Keys& keys, LinearSpec& p) {
  keys({"gives", "Whether A x + B u + c is the next state, or the rate of the state in time"},
       p.gives, WordForm{kLinearAnswerWords, "answer of a linear system"});
  keys({.name = "A", .says = "Square matrix by rows", .required = true}, p.A, MatrixForm{});
  keys({.name = "B", .says = "As many rows as A", .required = true}, p.B, MatrixForm{});
  keys({"c", "One number per row of A; zero by default"},
       CustomValue{[&](const YamlReader& reader) { read_offset(reader, p); },
                   [&] { return OrderedJson(std::vector<double>(p.c.begin(), p.c.end())); },
                   R"({"type": "array", "items": {"type": "number"}})"});
  if (YamlMap* map = keys.reading()) complete(*map, p);
}

template <class P>
void describe_parameters(Keys& keys, P& p) {
  for_each_field(p, [&](std::string_view key, std::string_view description, double& value,
                        const NumberRange& range) {
    keys({key, description}, value, NumberForm{range});
  });
}

using Parameters = decltype(SystemSpec::parameters);

template <class... P>
std::array<Parameters, sizeof...(P)> defaults(const std::variant<P...>* /*names the types*/) {
  return {P()...};
}

}  // namespace

void describe(Keys& keys, SystemSpec& system) {
  const SystemType& type = kSystemTypes[system.parameters.index()];
  const std::string schema = fmt::format(R"({{"const": "{}"}})", type.name);
  const bool is_own = std::holds_alternative<ExpressionSystemSpec>(system.parameters) ||
                      std::holds_alternative<LibrarySystemSpec>(system.parameters);
  keys.about({.title = type.name, .examples = type.examples, .rules = type.rules});
  keys({.name = "type", .says = type.description, .required = !is_own},
       CustomValue{[](const YamlReader&) {},  // read before the keys of its parameters
                   [&] { return OrderedJson(type.name); }, schema});
  std::visit([&](auto& parameters) { describe_parameters(keys, parameters); }, system.parameters);
}

SystemSpec default_system(std::size_t type) {
  return {.parameters = defaults(static_cast<const Parameters*>(nullptr))[type]};
}

namespace {

/// The system type determined by its other keys: equations, or a compiled function.
std::optional<std::size_t> type_by_keys(const YamlReader& reader) {
  constexpr std::size_t kExpressions = std::size(kSystemTypes) - 2;
  if (reader.has("rate") || reader.has("acceleration") || reader.has("next")) return kExpressions;
  if (reader.has("library")) return kExpressions + 1;
  // Systems of equations with a misspelled key, so that messages name that key.
  constexpr const char* kOfEquations[] = {"states",    "positions", "controls", "velocities",
                                          "state",     "control",   "rates",    "dynamics",
                                          "equations", "ode",       "rhs",      "xdot"};
  const auto has = [&](const char* key) { return reader.has(key); };
  if (!has("type") && std::ranges::any_of(kOfEquations, has)) return kExpressions;
  return std::nullopt;
}

std::optional<std::size_t> choose_type(const YamlReader& reader) {
  std::vector<std::string> words;
  for (const SystemType& known : kSystemTypes) words.emplace_back(known.name);
  return reader.choose(words, "type of system");
}

}  // namespace

bool SystemForm::read(const YamlReader& reader, SystemSpec& system) const {
  system.place = reader.place();
  YamlMap map(reader);
  const auto by_keys = type_by_keys(reader);
  const auto type = by_keys ? map.find("type") : map.require("type");
  const auto index = type ? choose_type(*type) : by_keys;
  if (!index) return map.ignore_others(), false;
  system.parameters = default_system(*index).parameters;
  const int errors = reader.diagnostics().error_count();
  KeyReader keys(map);
  describe(keys, system);
  if (reader.diagnostics().error_count() == errors) settle_own_system(reader, names, system);
  return true;
}

OrderedJson SystemForm::schema(const SystemSpec& /*of any type*/,
                               SchemaDefinitions& definitions) const {
  return defined(definitions, "system", [&] {
    OrderedJson types = OrderedJson::array();
    for (std::size_t i = 0; i < std::size(kSystemTypes); ++i)
      types.push_back(map_schema(definitions, default_system(i)));
    return OrderedJson{
        {"title", "Closed-form system"},
        {"type", "object"},
        {"oneOf", std::move(types)},
        {"description",
         "What moves: a built-in system or equations of the file, instead of a robot"},
        {"examples", OrderedJson::parse(R"([{"type": "pendulum", "mass": 2},
           {"type": "linear", "A": [[1, 0.1], [0, 1]], "B": [[0], [0.1]]}])")}};
  });
}

}  // namespace conddp
