#include "problem_file/footholds.hpp"

#include <algorithm>

#include "problem_file/phase_builder.hpp"

namespace conddp {
namespace {

bool is_swing_of(const CostSpec& cost, const std::string& frame) {
  return cost.swing && cost.frame && cost.frame->value == frame;
}

/// A swing and the phases in which it goes on.
struct Swing {
  const SwingSpec* spec;
  std::vector<bool> on;
  Vector3<double> from = Vector3<double>::zero();
};

}  // namespace

Vector3<double> landing_place(const SwingSpec& swing, const Vector3<double>& from) {
  return swing.landing.value_or(from + swing.step.value_or(Vector3<double>::zero()));
}

bool swings(const std::string& frame, const ProblemSpec& spec) {
  return std::any_of(spec.costs.begin(), spec.costs.end(),
                     [&](const CostSpec& cost) { return is_swing_of(cost, frame); });
}

std::vector<Vector3<double>> footholds(const std::string& frame, const Vector3<double>& start,
                                       const ProblemSpec& spec) {
  const std::size_t n = spec.phases.size();
  std::vector<Swing> all;
  Diagnostics reported_elsewhere;
  for (const CostSpec& cost : spec.costs)
    if (is_swing_of(cost, frame))
      all.push_back({&*cost.swing, phases_named(cost.phases, spec, reported_elsewhere)});
  std::vector<Vector3<double>> places(n + 1, start);
  for (std::size_t p = 0; p <= n; ++p) {
    if (p > 0) places[p] = places[p - 1];
    for (const Swing& swing : all)
      if (p > 0 && swing.on[p - 1] && (p == n || !swing.on[p]))
        places[p] = landing_place(*swing.spec, swing.from);
    for (Swing& swing : all)
      if (p < n && swing.on[p] && (p == 0 || !swing.on[p - 1])) swing.from = places[p];
  }
  return places;
}

}  // namespace conddp
