#include "problem_file/plant/collocation_builder.hpp"

#include <algorithm>
#include <map>

#include "ocp/knot/collocation_residual.hpp"

namespace conddp {
namespace {

constexpr const char* kName = "collocation";
constexpr const char* kOthers =
    "write another integrator: semi_implicit_euler, explicit_euler, rk2, rk3 or rk4";

/// Reports contacts, which collocation does not support.
void check_smoothness(const ProblemSpec& spec, Diagnostics& out) {
  for (const PhaseSpec& phase : spec.phases)
    if (phase.contacts.any())
      out.error(phase.name.place,
                phase.restitution
                    ? "collocation is for systems without contacts, hence without impulses"
                    : "collocation is for systems without contacts",
                kOthers);
  if (spec.terminal_contacts && spec.terminal_contacts->any())
    out.error(spec.integrator->place,
              "collocation is for systems without contacts, and the last node holds some", kOthers);
}

void check_names(const ProblemSpec& spec, Diagnostics& out) {
  for (const ConstraintSpec* constraint : spec.all_constraints())
    if (const Name& name = constraint->function.name; name.value == kName)
      out.error(name.place, "'collocation' is the name of the integrator's own constraint",
                "give the constraint another name");
}

/// Wraps the systems; phases that share a system still share it.
void collocate_systems(CollocationRule rule, Plant& plant) {
  std::map<const System*, std::shared_ptr<const System>> made;
  const auto wrap = [&](std::shared_ptr<const System>& system) {
    if (system->kind() == SystemKind::discrete) return;  // a jump
    std::shared_ptr<const System>& known = made[system.get()];
    if (!known) known = std::make_shared<CollocationSystem>(system, rule);
    system = known;
  };
  wrap(plant.system);
  for (std::shared_ptr<const System>& system : plant.systems) wrap(system);
  for (SystemVariant& variant : plant.variants) wrap(variant.system);
}

/// Initial guess of the slopes of a system's steps.
class SlopeGuess {
 public:
  explicit SlopeGuess(const CollocationSystem& system)
      : system_(system),
        inside_(*system.inside()),
        data_(inside_.create_data(double{})),
        u_(system.actuators()) {}

  /// Writes the slopes of knot k into the trajectory.
  void write(int k, const ShootingProblem& problem, Trajectory& trajectory) {
    const int n = system_.ndx(), rows = system_.rows(), stages = system_.later_stages();
    const KnotView& knot = problem.knot(k);
    auto w = trajectory.u(k);
    const Step& step = knot.model->step();
    const double* first = step.first_control(trajectory.x(k).data(), w.data());
    const double h = step.time_step(knot.dt, trajectory.x(k).data());
    const Eigen::VectorXd x = trajectory.x(k).head(n), next = trajectory.x(k + 1).head(n);
    Eigen::VectorXd begin = rate(x, first);
    const Eigen::VectorXd end = rate(next, w.data());
    if (!begin.allFinite()) begin = (next - x) / h;  // Radau rules do not need it
    w.segment(system_.slopes(stages), rows) = end.tail(rows);
    for (int i = 1; i < stages; ++i) {  // on the cubic through both ends
      const double c = system_.time(i), past = c * c * (3 - 2 * c);
      const Eigen::VectorXd between =
          (1 - past) * x + past * next + h * c * (1 - c) * ((1 - c) * begin - c * end);
      for (int j = 0; j < system_.actuators(); ++j) u_[j] = first[j] + c * (w[j] - first[j]);
      w.segment(system_.slopes(i), rows) = rate(between, u_.data()).tail(rows);
    }
  }

 private:
  /// ẋ; its last rows are the slopes.
  Eigen::VectorXd rate(const Eigen::VectorXd& x, const double* w) {
    const int n = system_.ndx(), rows = system_.rows(), top = n - rows;
    inside_.evaluate(x.data(), w, *data_);
    Eigen::VectorXd k(n);
    k << x.segment(top, top), Eigen::Map<const Eigen::VectorXd>(data_->f.data(), rows);
    return k;
  }

  const CollocationSystem& system_;
  const System& inside_;
  std::unique_ptr<SystemData<double>> data_;
  Eigen::VectorXd u_;  ///< at a stage
};

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
  collocate_systems(*rule, plant);
  return true;
}

void add_collocation_terms(KnotModel& model) {
  const std::shared_ptr<const CollocationSystem> system(model.shared_system(),
                                                        model.system().as_collocation());
  const Step& step = model.step();
  model.add_constraint(make_constraint(
      kName, collocation_residual(system, step.ndx(), step.duration(), step.has_linear_controls()),
      ConstraintKind::bounds));
}

void write_collocation_parameters(const KnotModel& model, double dt, double* parameters) {
  const ConstraintTerm& term = model.constraints().back();
  parameters[term.parameters] = dt;
  std::fill_n(parameters + term.lower(), 2 * term.rows, 0.0);
  parameters[term.active()] = 1;
}

void guess_slopes(const ShootingProblem& problem, Trajectory& trajectory) {
  std::map<const CollocationSystem*, SlopeGuess> guesses;
  for (int k = 0; k < problem.knots(); ++k)
    if (const auto* system = problem.knot(k).model->system().as_collocation())
      guesses.try_emplace(system, *system).first->second.write(k, problem, trajectory);
}

}  // namespace conddp
