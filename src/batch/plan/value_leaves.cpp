#include "batch/plan/value_leaves.hpp"

namespace conddp {
namespace {

std::string behind(const std::string& path, const std::string& step) {
  return path.empty() ? step : path + '.' + step;
}

void add_leaves(const OrderedJson& value, const std::string& path, std::vector<ValueLeaf>& leaves) {
  if (!value.is_structured() || value.empty()) {
    leaves.push_back({path, value});
    return;
  }
  for (const auto& [step, part] : value.items()) add_leaves(part, behind(path, step), leaves);
}

}  // namespace

std::vector<ValueLeaf> leaves_of(const std::string& text) {
  std::vector<ValueLeaf> leaves;
  add_leaves(OrderedJson::parse(text), {}, leaves);
  return leaves;
}

}  // namespace conddp
