#include "systems/graphs/table_arguments.hpp"

namespace conddp {

TableArguments::TableArguments(const ExpressionGraph& graph, std::span<const NodeId> roots,
                               int inputs, const std::vector<std::string>& names) {
  std::vector<NodeId> arguments;
  for (const NodeId id : nodes_below(graph, roots)) {
    const ExpressionNode& node = graph[id];
    if (node.operation != Operation::kTable) continue;
    const int index = TableUse::of(node.payload).table;
    const SplineTable& table = *graph.tables()[index];
    for (int i = 0; i < table.arguments(); ++i) {
      arguments.push_back(i == 0 ? node.a : node.b);
      tables_.push_back({names[index], 0, table.first(i), table.last(i)});
    }
  }
  program_ = ExpressionProgram(graph, arguments, inputs, static_cast<int>(arguments.size()));
}

std::vector<TableReading> TableArguments::readings(const std::function<double(int)>& input) const {
  std::vector<TableReading> readings = tables_;
  if (readings.empty()) return readings;
  std::vector<double> registers(program_.registers());
  program_.prepare(registers.data());
  for (int i = 0; i < program_.inputs(); ++i) registers[i] = input(i);
  program_.run(registers.data());
  for (std::size_t i = 0; i < readings.size(); ++i)
    readings[i].at = registers[program_.output(static_cast<int>(i))];
  return readings;
}

}  // namespace conddp
