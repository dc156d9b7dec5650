#include "problem_file/expand/expand_sections.hpp"
#include "problem_file/spec/system_fields.hpp"

namespace conddp {
namespace {

OrderedJson expand_matrix(const Eigen::MatrixXd& matrix) {
  OrderedJson rows = OrderedJson::array();
  for (Eigen::Index i = 0; i < matrix.rows(); ++i) {
    OrderedJson row = OrderedJson::array();
    for (Eigen::Index j = 0; j < matrix.cols(); ++j) row.push_back(matrix(i, j));
    rows.push_back(std::move(row));
  }
  return rows;
}

void expand(const DoubleIntegratorSpec& p, OrderedJson& json) { json["dimension"] = p.dimension; }

void expand(const LinearSpec& p, OrderedJson& json) {
  json["A"] = expand_matrix(p.A);
  json["B"] = expand_matrix(p.B);
  json["c"] = std::vector<double>(p.c.begin(), p.c.end());
}

template <class P>
void expand(const P& p, OrderedJson& json) {
  for_each_field(p, [&](std::string_view key, std::string_view, double value, const NumberRange&) {
    json[std::string(key)] = value;
  });
}

}  // namespace

OrderedJson expand_system(const SystemSpec& system) {
  OrderedJson json = {{"type", kSystemTypes[system.parameters.index()].name}};
  std::visit([&](const auto& parameters) { expand(parameters, json); }, system.parameters);
  return json;
}

}  // namespace conddp
