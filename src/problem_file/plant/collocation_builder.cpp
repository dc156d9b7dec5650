#include "problem_file/plant/collocation_builder.hpp"

#include <algorithm>

#include "ocp/knot/collocation_residual.hpp"

namespace conddp {
namespace {

constexpr const char* kName = "collocation";
constexpr const char* kOthers =
    "write another integrator: semi_implicit_euler, explicit_euler, rk2, rk3 or rk4";

/// What moves without a slope, or with one that jumps.
void check_smoothness(const ProblemSpec& spec, Diagnostics& out) {
  for (const PhaseSpec& phase : spec.phases)
    if (phase.contacts.any())
      out.error(phase.name.place,
                phase.restitution ? "collocation does not support impulses"
                                  : "collocation is for systems without contacts",
                kOthers);
  for (const PhaseSpec& phase : spec.phases)
    if (phase.jump) out.error(phase.name.place, "collocation does not support jumps", kOthers);
  if (!spec.systems.empty())
    out.error(spec.integrator->place, "collocation does not support several systems", kOthers);
  if (spec.terminal_contacts && spec.terminal_contacts->any())
    out.error(spec.integrator->place,
              "collocation is for systems without contacts, and the last node holds some", kOthers);
}

void check_names(const ProblemSpec& spec, Diagnostics& out) {
  for (const ConstraintSpec* constraint : spec.all_constraints())
    if (const Name& name = constraint->function.name; name.value == kName)
      out.error(name.place, "'collocation' is the name of what the integrator's steps obey",
                "give the constraint another name");
}

}  // namespace

bool collocate(const ProblemSpec& spec, Plant& plant, Diagnostics& out) {
  if (!spec.integrator) return true;
  const auto rule = info_of(spec.integrator->value).collocation;
  if (!rule) return true;
  const int errors = out.error_count();
  check_smoothness(spec, out);
  check_names(spec, out);
  if (plant.system->kind() == SystemKind::discrete)
    out.error(spec.integrator->place,
              "this system gives the next state itself: nothing is integrated",
              "write 'integrator: discrete' or leave the key out");
  else if (!plant.system->manifold().curved().empty())
    out.error(spec.integrator->place,
              "collocation needs a state without rotations in space, and this one turns freely",
              kOthers);
  if (out.error_count() > errors) return false;
  plant.system = std::make_shared<CollocationSystem>(plant.system, *rule);
  return true;
}

void add_collocation_terms(const std::shared_ptr<const CollocationSystem>& system,
                           KnotModel& model) {
  model.add_constraint(make_constraint(
      kName,
      collocation_residual(system, model.ndx(), model.free_duration(), model.has_linear_controls()),
      ConstraintKind::bounds));
}

void write_collocation_parameters(const KnotModel& model, double dt, double* parameters) {
  const ConstraintTerm& term = model.constraints().back();
  parameters[term.parameters] = dt;
  std::fill_n(parameters + term.lower(), 2 * term.rows, 0.0);
  parameters[term.active()] = 1;
}

void guess_slopes(const CollocationSystem& system, const ShootingProblem& problem,
                  Trajectory& trajectory) {
  const System& inside = *system.inside();
  const auto data = inside.create_data(double{});
  const int n = system.ndx(), rows = system.rows(), top = n - rows;
  const int stages = system.later_stages();
  Eigen::VectorXd u(system.actuators());  // at a stage
  // ẋ, of which the last rows are the slopes.
  const auto rate = [&](const Eigen::VectorXd& x, const double* w) {
    inside.evaluate(x.data(), w, *data);
    Eigen::VectorXd k(n);
    k << x.segment(top, top), Eigen::Map<const Eigen::VectorXd>(data->f.data(), rows);
    return k;
  };
  for (int k = 0; k < problem.knots(); ++k) {
    const KnotView& knot = problem.knot(k);
    if (problem.phases()[knot.phase].instant) continue;
    auto w = trajectory.u(k);
    const bool linear = knot.model->has_linear_controls();
    const double* first =
        linear ? trajectory.x(k).data() + problem.nx() - system.actuators() : w.data();
    const double h = knot.model->step(knot.dt, trajectory.x(k).data());
    const Eigen::VectorXd x = trajectory.x(k).head(n), next = trajectory.x(k + 1).head(n);
    Eigen::VectorXd begin = rate(x, first);
    const Eigen::VectorXd end = rate(next, w.data());
    if (!begin.allFinite()) begin = (next - x) / h;  // rules of Radau do without it
    w.segment(system.slopes(stages), rows) = end.tail(rows);
    for (int i = 1; i < stages; ++i) {  // on the cubic through both ends
      const double c = system.time(i), past = c * c * (3 - 2 * c);
      const Eigen::VectorXd between =
          (1 - past) * x + past * next + h * c * (1 - c) * ((1 - c) * begin - c * end);
      for (int j = 0; j < system.actuators(); ++j) u[j] = first[j] + c * (w[j] - first[j]);
      w.segment(system.slopes(i), rows) = rate(between, u.data()).tail(rows);
    }
  }
}

}  // namespace conddp
