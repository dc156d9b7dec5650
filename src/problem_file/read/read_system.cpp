#include <algorithm>
#include <array>

#include <fmt/format.h>

#include "base/text/spelling.hpp"
#include "problem_file/read/read_sections.hpp"
#include "problem_file/spec/enum_names.hpp"
#include "problem_file/spec/system_fields.hpp"

namespace conddp {
namespace {

/// Maximum number of rows and columns of a matrix.
constexpr std::size_t kLargest = 1000;

std::optional<Eigen::RowVectorXd> read_row(const YamlReader& reader) {
  const auto numbers = reader.numbers();
  if (!numbers) return std::nullopt;
  if (numbers->size() <= kLargest)
    return Eigen::RowVectorXd(
        Eigen::Map<const Eigen::RowVectorXd>(numbers->data(), numbers->size()));
  reader.error(fmt::format("a matrix has at most {} columns", kLargest));
  return std::nullopt;
}

std::optional<Eigen::MatrixXd> read_matrix(const YamlReader& reader) {
  const auto rows = reader.items();
  if (!rows) return std::nullopt;
  if (rows->size() > kLargest)
    return reader.error(fmt::format("a matrix has at most {} rows", kLargest)), std::nullopt;
  Eigen::MatrixXd matrix;
  for (std::size_t i = 0; i < rows->size(); ++i) {
    const YamlReader& reader_of_row = (*rows)[i];
    const auto row = read_row(reader_of_row);
    if (!row) return std::nullopt;
    if (i == 0) matrix.resize(rows->size(), row->size());
    if (row->size() != matrix.cols()) {
      reader_of_row.error(fmt::format("this row has {}, the first one has {}",
                                      counted(row->size(), "number"), matrix.cols()));
      return std::nullopt;
    }
    matrix.row(i) = *row;
  }
  if (matrix.size() == 0) return reader.error("the matrix is empty"), std::nullopt;
  return matrix;
}

void read(YamlMap& map, const FileContext&, DoubleIntegratorSpec& p) {
  map.integer("dimension", p.dimension, 1, 1000);
}

/// Checks that A is square and B has as many rows.
bool check_sizes(const YamlReader& A, const Eigen::MatrixXd& a, const YamlReader& B,
                 const Eigen::MatrixXd& b) {
  if (a.rows() != a.cols())
    return A.error(fmt::format("A is {} x {}, not square", a.rows(), a.cols())), false;
  if (b.rows() == a.rows()) return true;
  return B.error(fmt::format("B has {} rows and A has {}", b.rows(), a.rows())), false;
}

void read(YamlMap& map, const FileContext&, LinearSpec& p) {
  map.choice("gives", p.gives, kLinearAnswerWords, "answer of a linear system");
  const auto A = map.require("A");
  const auto B = map.require("B");
  const auto c = map.find("c");
  if (!A || !B) return;
  const auto a = read_matrix(*A);
  const auto b = read_matrix(*B);
  if (!a || !b || !check_sizes(*A, *a, *B, *b)) return;
  p.A = *a;
  p.B = *b;
  p.c = Eigen::VectorXd::Zero(a->rows());
  if (c)
    if (const auto n = c->numbers(a->rows(), "one per row of A"))
      p.c = Eigen::Map<const Eigen::VectorXd>(n->data(), n->size());
}

void read(YamlMap& map, const FileContext& file, ExpressionSystemSpec& p) {
  read_expression_system(map, file, p);
}

void read(YamlMap& map, const FileContext& file, LibrarySystemSpec& p) {
  read_library_system(map, file.folder, p);
}

template <class P>
void read(YamlMap& map, const FileContext&, P& p) {
  for_each_field(p, [&](std::string_view key, std::string_view, double& value,
                        const NumberRange& range) { map.number(key, value, range); });
}

using Parameters = decltype(SystemSpec::parameters);

template <class P>
Parameters read_as(YamlMap& map, const FileContext& file) {
  P parameters;
  read(map, file, parameters);
  return parameters;
}

/// The reader of each alternative.
template <class... P>
constexpr std::array<Parameters (*)(YamlMap&, const FileContext&), sizeof...(P)> readers(
    const std::variant<P...>* /*names the types*/) {
  return {read_as<P>...};
}
constexpr auto kReaders = readers(static_cast<const Parameters*>(nullptr));

/// The system type determined by its other keys: equations, or a compiled function.
std::optional<std::size_t> type_by_keys(const YamlNode& node) {
  constexpr std::size_t kExpressions = std::size(kSystemTypes) - 2;
  if (node.find("rate") || node.find("acceleration") || node.find("next")) return kExpressions;
  if (node.find("library")) return kExpressions + 1;
  // Systems of equations with a misspelled key, so that messages name that key.
  constexpr const char* kOfEquations[] = {"states",    "positions", "controls", "velocities",
                                          "state",     "control",   "rates",    "dynamics",
                                          "equations", "ode",       "rhs",      "xdot"};
  const auto has = [&](const char* key) { return node.find(key) != nullptr; };
  if (!has("type") && std::ranges::any_of(kOfEquations, has)) return kExpressions;
  return std::nullopt;
}

std::optional<std::size_t> choose_type(const YamlReader& reader) {
  std::vector<std::string> words;
  for (const SystemType& known : kSystemTypes) words.emplace_back(known.name);
  return reader.choose(words, "type of system");
}

}  // namespace

SystemSpec read_system(const YamlReader& reader, const FileContext& file) {
  SystemSpec system{.place = reader.place()};
  YamlMap map(reader);
  const auto by_keys = type_by_keys(reader.node());
  const auto type = by_keys ? map.find("type") : map.require("type");
  const auto index = type ? choose_type(*type) : by_keys;
  if (index)
    system.parameters = kReaders[*index](map, file);
  else
    map.ignore_others();
  return system;
}

}  // namespace conddp
