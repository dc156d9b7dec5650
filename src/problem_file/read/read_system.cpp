#include <array>

#include <fmt/format.h>

#include "problem_file/read/read_sections.hpp"
#include "problem_file/spec/system_fields.hpp"

namespace conddp {
namespace {

std::optional<Eigen::MatrixXd> read_matrix(const YamlReader& reader) {
  const auto rows = reader.items();
  if (!rows) return std::nullopt;
  constexpr std::size_t kLargest = 1000;
  if (rows->size() > kLargest)
    return reader.error(fmt::format("a matrix has at most {} rows", kLargest)), std::nullopt;
  Eigen::MatrixXd matrix;
  for (std::size_t i = 0; i < rows->size(); ++i) {
    const auto row = (*rows)[i].numbers();
    if (!row) return std::nullopt;
    if (row->size() > kLargest) {
      (*rows)[i].error(fmt::format("a matrix has at most {} columns", kLargest));
      return std::nullopt;
    }
    if (i == 0) matrix.resize(rows->size(), row->size());
    if (static_cast<Eigen::Index>(row->size()) != matrix.cols()) {
      (*rows)[i].error(
          fmt::format("this row has {} numbers, the first one has {}", row->size(), matrix.cols()));
      return std::nullopt;
    }
    for (std::size_t j = 0; j < row->size(); ++j) matrix(i, j) = (*row)[j];
  }
  if (matrix.size() == 0) return reader.error("the matrix is empty"), std::nullopt;
  return matrix;
}

void read(YamlMap& map, const FileContext&, DoubleIntegratorSpec& p) {
  map.integer("dimension", p.dimension, 1, 1000);
}

void read(YamlMap& map, const FileContext&, LinearSpec& p) {
  const auto A = map.require("A");
  const auto B = map.require("B");
  const auto c = map.find("c");
  if (!A || !B) return;
  const auto a = read_matrix(*A);
  const auto b = read_matrix(*B);
  if (!a || !b) return;
  if (a->rows() != a->cols())
    return A->error(fmt::format("A is {} x {}, not square", a->rows(), a->cols()));
  if (b->rows() != a->rows())
    return B->error(fmt::format("B has {} rows and A has {}", b->rows(), a->rows()));
  p.A = *a;
  p.B = *b;
  p.c = Eigen::VectorXd::Zero(a->rows());
  if (c)
    if (const auto n = c->numbers(a->rows(), "one a row of A"))
      p.c = Eigen::Map<const Eigen::VectorXd>(n->data(), n->size());
}

void read(YamlMap& map, const FileContext& file, ExpressionSystemSpec& p) {
  read_expression_system(map, file, p);
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

}  // namespace

SystemSpec read_system(const YamlReader& reader, const FileContext& file) {
  SystemSpec system{.place = reader.place()};
  YamlMap map(reader);
  // Equations say themselves what the system is.
  const YamlNode& node = reader.node();
  const bool in_words = node.find("rate") || node.find("acceleration") || node.find("next");
  const auto type = in_words ? map.find("type") : map.require("type");
  std::vector<std::string> words;
  for (const SystemType& known : kSystemTypes) words.emplace_back(known.name);
  auto index = type ? type->choose(words, "type of system") : std::nullopt;
  if (!type && in_words) index = words.size() - 1;
  if (index)
    system.parameters = kReaders[*index](map, file);
  else
    map.ignore_others();
  return system;
}

}  // namespace conddp
