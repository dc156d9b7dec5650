#include <algorithm>

#include <fmt/format.h>

#include "ocp/step/integrator_table.hpp"
#include "problem_file/read/read_sections.hpp"

namespace conddp {

void describe(Keys& keys, MeshSpec& mesh) {
  constexpr int kMostRounds = 20, kMostFactor = 10'000;
  static const NumberRange kError{1e-12, 1, false, false, "a number from 1e-12 to 1"};
  keys.about({.definition = "mesh",
              .title = "A grid that is refined",
              .says = "The problem is solved again on finer grids, each from the answer before, "
                      "until a replay of the controls in a tenth of the steps agrees",
              .examples = R"([{"error": 1.0e-6}])"});
  keys({.name = "error",
        .says = "How far a state may lie from that of the replay, in its unit",
        .required = true},
       mesh.error, NumberForm{kError});
  keys({"factor", "Into how many each step of the phases is cut to begin with"}, mesh.factor,
       IntegerForm{1, kMostFactor});
  keys({"rounds", "Grids at most, the first one included"}, mesh.rounds,
       IntegerForm{1, kMostRounds});
  keys({"knots", "Knots at most, of all phases together"}, mesh.most_knots,
       IntegerForm{1, kMaxKnots});
}

MeshSpec read_mesh(const YamlReader& reader) {
  MeshSpec mesh{.place = reader.place()};
  read_map(reader, mesh, "write '{error: 1.0e-6}'");
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
