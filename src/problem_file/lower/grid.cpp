#include "problem_file/lower/grid.hpp"

#include <algorithm>

#include <fmt/format.h>

#include "base/text/spelling.hpp"
#include "ocp/step/integrator_table.hpp"
#include "problem_file/model/named_phases.hpp"

namespace conddp {
namespace {

/// Phase index of each knot.
std::vector<std::size_t> phases_by_knot(const ProblemSpec& spec) {
  std::vector<std::size_t> phases;
  for (std::size_t p = 0; p < spec.phases.size(); ++p)
    phases.insert(phases.end(), spec.phases[p].knots.value, p);
  return phases;
}

/// "'trot' has 0 to 9, 'stand' has 20 to 29".
std::string knots_of(const std::vector<bool>& named, const ProblemSpec& spec) {
  std::string ranges;
  int first = 0;
  for (std::size_t p = 0; p < spec.phases.size(); ++p) {
    const int end = first + spec.phases[p].knots.value;
    if (named[p])
      ranges += fmt::format("{}'{}' has {} to {}", ranges.empty() ? "" : ", ",
                            spec.phases[p].name.value, first, end - 1);
    first = end;
  }
  return ranges;
}

/// Reports knots in phases that the function does not name.
void check_phases(const CostSpec& function, const ProblemSpec& spec, Diagnostics& out) {
  if (!function.phases) return;
  const std::vector<bool> named = phases_named(function.phases, spec);
  if (std::ranges::find(named, true) == named.end()) return;  // unknown names are reported later
  const std::vector<std::size_t> phase_of = phases_by_knot(spec);
  for (const KnotSpec& knot : *function.knots) {
    const auto index = static_cast<std::size_t>(knot.value);
    if (index >= phase_of.size() || named[phase_of[index]]) continue;
    out.error(knot.place,
              fmt::format("knot {} is in the phase '{}', which '{}' does not name", knot.value,
                          spec.phases[phase_of[index]].name.value, function.name.value),
              "knots are numbered over all phases: " + knots_of(named, spec));
  }
}

/// Reports knots and way-points that do not exist. `hint`: advice on the last node.
void check_function(const CostSpec& function, const char* hint, const ProblemSpec& spec,
                    Diagnostics& out) {
  const int count = spec.knots();
  if (function.knots) {
    for (const KnotSpec& knot : *function.knots)
      if (knot.value >= count)
        out.error(knot.place, fmt::format("running knots are numbered from 0 to {}", count - 1),
                  hint);
    check_phases(function, spec, out);
  }
  if (!function.reference) return;
  for (const KnotSpec& knot : function.reference->knots)
    if (knot.value > count)
      out.error(knot.place, fmt::format("knot {} lies behind the last one, {}", knot.value, count));
}

void renumber(CostSpec& cost, const std::function<int(int)>& number_of) {
  if (cost.knots)
    for (KnotSpec& knot : *cost.knots) knot.value = number_of(knot.value);
  if (cost.reference)
    for (KnotSpec& knot : cost.reference->knots) knot.value = number_of(knot.value);
}

/// First knot of each phase by name.
class FirstKnots {
 public:
  FirstKnots(const ProblemSpec& spec, Diagnostics& out) : out_(out) {
    int first = 0;
    for (const PhaseSpec& phase : spec.phases) {
      names_.push_back(phase.name.value);
      first_.push_back(first);
      first += phase.knots.value;
    }
  }

  /// Counts a knot over all phases.
  void number(KnotSpec& knot) const {
    if (knot.phase.empty()) return;
    const auto found = std::ranges::find(names_, knot.phase);
    if (found == names_.end())
      return out_.error(knot.place, fmt::format("unknown phase '{}'", knot.phase),
                        name_hint(knot.phase, names_, "phases"));
    knot.value += first_[found - names_.begin()];
    knot.phase.clear();
    if (knot.value < 0) out_.error(knot.place, "this is before the first knot");
  }
  void number(CostSpec& function) const {
    if (function.knots)
      for (auto knot = function.knots->begin(); knot != function.knots->end(); ++knot) {
        number(*knot);
        if (std::find_if(function.knots->begin(), knot,
                         [&](const KnotSpec& other) { return other.value == knot->value; }) != knot)
          out_.error(knot->place, fmt::format("{} stands twice in the list", knot->value));
      }
    if (!function.reference) return;
    std::vector<KnotSpec>& knots = function.reference->knots;
    for (std::size_t i = 0; i < knots.size(); ++i) {
      number(knots[i]);
      if (i > 0 && knots[i].value <= knots[i - 1].value)
        out_.error(knots[i].place, "the knots must increase");
    }
  }

 private:
  Diagnostics& out_;
  std::vector<std::string> names_;
  std::vector<int> first_;
};

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

void number_knots(ProblemSpec& spec, Diagnostics& out) {
  const FirstKnots first(spec, out);
  for (auto* costs : {&spec.costs, &spec.integrals, &spec.terminal_costs})
    for (CostSpec& cost : *costs) first.number(cost);
  for (auto* constraints : {&spec.constraints, &spec.terminal_constraints})
    for (ConstraintSpec& constraint : *constraints) first.number(constraint.function);
  for (KeyframeSpec& keyframe : spec.guess.keyframes)
    if (keyframe.knot) first.number(*keyframe.knot);
}

void check_knots(const ProblemSpec& spec, Diagnostics& out) {
  for (const CostSpec* cost : spec.all_costs())
    check_function(*cost, "costs on the last node stand under 'terminal'", spec, out);
  for (const ConstraintSpec* constraint : spec.all_constraints())
    check_function(constraint->function, "constraints on the last node stand under 'terminal'",
                   spec, out);
  for (const KeyframeSpec& keyframe : spec.guess.keyframes)
    if (keyframe.knot && keyframe.knot->value > spec.knots())
      out.error(keyframe.knot->place, fmt::format("nodes are numbered from 0 to {}", spec.knots()));
}

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
    return static_cast<int>(new_from + steps * new_count / count);  // the last node: steps = count
  });
}

void cut_steps(ProblemSpec& spec, Diagnostics& out) {
  if (!spec.mesh) return;
  MeshSpec& mesh = *spec.mesh;
  long long knots = 0;
  for (const PhaseSpec& phase : spec.phases)
    knots += static_cast<long long>(phase.knots.value) * (phase.takes_no_time() ? 1 : mesh.factor);
  if (knots > kMaxKnots)
    return out.error(mesh.place,
                     fmt::format("the phases have more than {} knots together", kMaxKnots));
  set_knots(spec, [&mesh](int own) { return own * mesh.factor; });
  mesh.is_cut = true;
  tighten(spec);
}

}  // namespace conddp
