#include <algorithm>

#include <fmt/format.h>

#include "ocp/step/integrator_table.hpp"
#include "problem_file/read/read_sections.hpp"

namespace conddp {

MeshSpec read_mesh(const YamlReader& reader) {
  constexpr int kMostRounds = 20, kMostFactor = 10'000;
  static const NumberRange kError{1e-12, 1, false, false, "a number from 1e-12 to 1"};
  MeshSpec mesh{.place = reader.place()};
  YamlMap map(reader, "write '{error: 1.0e-6}'");
  if (!map.valid()) return mesh;
  map.require("error");
  map.number("error", mesh.error, kError);
  map.integer("factor", mesh.factor, 1, kMostFactor);
  map.integer("rounds", mesh.rounds, 1, kMostRounds);
  map.integer("knots", mesh.most_knots, 1, kMaxKnots);
  return mesh;
}

void cut_steps(const MeshSpec& mesh, std::vector<PhaseSpec>& phases, Diagnostics& out) {
  long long knots = 0;
  for (const PhaseSpec& phase : phases)
    knots += static_cast<long long>(phase.knots.value) * (phase.takes_no_time() ? 1 : mesh.factor);
  if (knots > mesh.most_knots)
    return out.error(mesh.place,
                     fmt::format("the phases have {} knots together, and 'knots' allows {}", knots,
                                 mesh.most_knots));
  for (PhaseSpec& phase : phases) {
    if (phase.takes_no_time()) continue;
    phase.knots.value *= mesh.factor;
    phase.dt /= mesh.factor;
  }
}

void tighten_for_mesh(const MeshSpec& mesh, ProblemSpec& spec) {
  if (!spec.integrator || !info_of(spec.integrator->value).collocation) return;
  // Violations of the steps accumulate over the knots. Below kLeast, only rounding remains.
  constexpr double kShare = 0.1, kLeast = 1e-11;
  double& tolerance = spec.solver.options.tolerances.constraint;
  const double wanted = kShare * mesh.error / std::max(1, spec.knots());
  tolerance = std::min(tolerance, std::max(wanted, kLeast));
}

}  // namespace conddp
