#include "problem_file/model/spec_expression.hpp"

namespace conddp {

void add_names(const ExpressionNamesSpec& names, NamedParameters& parameters, NamedTables& tables) {
  parameters.insert(parameters.end(), names.parameters.begin(), names.parameters.end());
  for (const TableSpec& table : names.tables) tables.emplace_back(table.name.value, table.function);
}

}  // namespace conddp
