#include "problem_file/lower/grid.hpp"

#include <algorithm>

#include <fmt/format.h>

#include "ocp/step/integrator_table.hpp"

namespace conddp {
namespace {

void renumber(CostSpec& cost, const std::function<int(int)>& number_of) {
  if (cost.knots)
    for (Located<int>& knot : *cost.knots) knot.value = number_of(knot.value);
  if (cost.reference)
    for (Located<int>& knot : cost.reference->knots) knot.value = number_of(knot.value);
}

/// With collocation, lowers the constraint tolerance to the share of the mesh's error.
void tighten(ProblemSpec& spec) {
  if (!spec.integrator || !info_of(spec.integrator->value).collocation) return;
  // Violations of the steps accumulate over the knots. Below kLeast, only rounding remains.
  constexpr double kShare = 0.1, kLeast = 1e-11;
  double& tolerance = spec.solver.options.tolerances.constraint;
  const double wanted = kShare * spec.mesh->error / std::max(1, spec.knots());
  tolerance = std::min(tolerance, std::max(wanted, kLeast));
}

}  // namespace

void renumber(ProblemSpec& spec, const std::function<int(int)>& number_of) {
  for (auto* costs : {&spec.costs, &spec.integrals, &spec.terminal_costs})
    for (CostSpec& cost : *costs) renumber(cost, number_of);
  for (auto* constraints : {&spec.constraints, &spec.terminal_constraints})
    for (ConstraintSpec& constraint : *constraints) renumber(constraint.function, number_of);
  for (KeyframeSpec& keyframe : spec.guess.keyframes)
    if (keyframe.knot) keyframe.knot->value = number_of(keyframe.knot->value);
  for (WayPoint& point : spec.gait_way) point.node = number_of(point.node);
}

void set_knots(ProblemSpec& spec, const std::function<int(int)>& knots_of) {
  struct Run {
    int first, knots, new_first, new_knots;
  };
  std::vector<Run> runs;
  int first = 0, new_first = 0;
  for (PhaseSpec& phase : spec.phases) {
    int& knots = phase.knots.value;
    const int now = phase.takes_no_time() ? knots : knots_of(knots);
    runs.push_back({first, knots, new_first, now});
    first += knots;
    new_first += now;
    phase.dt /= static_cast<double>(now) / knots;
    knots = now;
  }
  renumber(spec, [&](int node) {
    const auto after = std::ranges::upper_bound(runs, node, {}, &Run::first);
    if (after == runs.begin()) return node;
    const auto& [from, count, new_from, new_count] = *std::prev(after);
    const long long steps = node - from;
    // The last node, and numbers beyond it, which are reported later, stay as far behind the end.
    if (steps >= count) return static_cast<int>(new_from + new_count + steps - count);
    return static_cast<int>(new_from + steps * new_count / count);
  });
}

void cut_steps(ProblemSpec& spec, Diagnostics& out) {
  if (!spec.mesh) return;
  MeshSpec& mesh = *spec.mesh;
  long long knots = 0;
  for (const PhaseSpec& phase : spec.phases)
    knots += static_cast<long long>(phase.knots.value) * (phase.takes_no_time() ? 1 : mesh.factor);
  if (knots > mesh.most_knots)
    return out.error(mesh.place,
                     fmt::format("the phases have {} knots together, and 'knots' allows {}", knots,
                                 mesh.most_knots));
  set_knots(spec, [&mesh](int own) { return own * mesh.factor; });
  mesh.is_cut = true;
  tighten(spec);
}

}  // namespace conddp
