#include "analysis/certificate/check.hpp"

#include <fmt/format.h>

namespace conddp {

std::string place_text(const ShootingProblem& problem, int knot, const std::string& quantity) {
  std::string text = fmt::format("knot {}", knot);
  if (knot < problem.knots())
    text += fmt::format(" (phase '{}')", problem.phases()[problem.knot(knot).phase].name);
  else
    text += " (the last node)";
  return quantity.empty() ? text : text + ", " + quantity;
}

std::string control_name(const ShootingProblem& problem, int knot, int entry) {
  if (knot < 0 || knot >= problem.knots() || entry < 0) return {};
  const auto& columns = problem.knot(knot).model->system().control_columns();
  return entry < static_cast<int>(columns.size()) ? columns[entry].name : std::string();
}

}  // namespace conddp
