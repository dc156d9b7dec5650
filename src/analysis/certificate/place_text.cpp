#include "analysis/certificate/place_text.hpp"

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

}  // namespace conddp
