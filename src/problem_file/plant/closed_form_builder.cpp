#include "problem_file/plant/closed_form_builder.hpp"

#include <algorithm>

#include <fmt/format.h>

#include "problem_file/plant/library_builder.hpp"

namespace conddp {
namespace {

template <class... Cases>
struct Overloaded : Cases... {
  using Cases::operator()...;
};
template <class... Cases>
Overloaded(Cases...) -> Overloaded<Cases...>;  // some compilers do not deduce it themselves

/// The common step of all phases, which a discrete system requires.
std::optional<double> common_step(const ProblemSpec& spec, Diagnostics& out) {
  const PhaseSpec& first = *std::find_if(spec.phases.begin(), spec.phases.end() - 1,
                                         [](const PhaseSpec& p) { return !p.takes_no_time(); });
  const double dt = first.dt;
  for (const PhaseSpec& phase : spec.phases)
    if (phase.takes_no_time()) {
      continue;
    } else if (phase.refine) {
      out.error(phase.name.place, "the steps of this system must have the same length",
                fmt::format("leave 'refine' out of '{}'", phase.name.value));
      return std::nullopt;
    } else if (phase.dt != dt) {
      out.error(phase.name.place, "the phases of this system must have the same dt",
                fmt::format("'{}' has {}, '{}' has {}", first.name.value, dt, phase.name.value,
                            phase.dt));
      return std::nullopt;
    }
  return dt;
}

}  // namespace

std::shared_ptr<const System> make_system(const SystemSpec& system, const ProblemSpec& spec,
                                          Diagnostics& out) {
  using Result = std::shared_ptr<const System>;
  return std::visit(
      Overloaded{
          [](const DoubleIntegratorSpec& p) -> Result { return double_integrator(p.dimension); },
          [](const LinearSpec& p) -> Result { return linear_system(p.A, p.B, p.c, p.gives); },
          [](const PendulumParameters& p) -> Result { return pendulum(p); },
          [](const CartpoleParameters& p) -> Result { return cartpole(p); },
          [](const AcrobotParameters& p) -> Result { return acrobot(p); },
          [](const UnicycleSpec&) -> Result { return unicycle(); },
          [&](const CarSpec& p) -> Result {
            const auto step = common_step(spec, out);
            return step ? car(p.wheelbase, *step) : nullptr;
          },
          [](const PlanarQuadrotorParameters& p) -> Result { return planar_quadrotor(p); },
          [](const QuadrotorParameters& p) -> Result { return quadrotor(p); },
          [](const LanderParameters& p) -> Result { return lander(p); },
          [](const ExpressionSystemSpec& p) -> Result { return p.parsed.system; },
          [&](const LibrarySystemSpec& p) -> Result { return build_library_system(p, out); },
      },
      system.parameters);
}

}  // namespace conddp
