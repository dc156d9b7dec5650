#include "problem_file/collocation_builder.hpp"

#include <algorithm>

#include "ocp/collocation_residual.hpp"

namespace conddp {
namespace {

constexpr const char* kName = "collocation";
constexpr const char* kOthers =
    "write another integrator: semi_implicit_euler, explicit_euler, rk2, rk3 or rk4";

/// What moves without a slope, or with one that jumps.
void check_smoothness(const ProblemSpec& spec, Diagnostics& out) {
  for (const PhaseSpec& phase : spec.phases)
    if (phase.contacts.all || !phase.contacts.names.empty())
      out.error(phase.name.place,
                phase.restitution ? "collocation knows no impulses"
                                  : "collocation is for systems without contacts",
                kOthers);
  if (spec.terminal_contacts &&
      (spec.terminal_contacts->all || !spec.terminal_contacts->names.empty()))
    out.error(spec.integrator->place,
              "collocation is for systems without contacts, and the last node holds some", kOthers);
  for (const auto* list : {&spec.constraints, &spec.terminal_constraints})
    for (const ConstraintSpec& constraint : *list)
      if (const Name& name = constraint.function.name; name.value == kName)
        out.error(name.place, "'collocation' is the name of what the integrator's steps obey",
                  "give the constraint another name");
}

}  // namespace

bool collocate(const ProblemSpec& spec, Plant& plant, Diagnostics& out) {
  if (!spec.integrator) return true;
  const auto rule = lobatto_rule(spec.integrator->value);
  if (!rule) return true;
  const int errors = out.error_count();
  check_smoothness(spec, out);
  if (plant.system->kind() == SystemKind::discrete)
    out.error(spec.integrator->place,
              "this system gives the next state itself: nothing is integrated",
              "write 'integrator: discrete' or leave the key out");
  else if (!plant.system->manifold().curved().empty())
    out.error(spec.integrator->place,
              "collocation needs a state without rotations in space, and this one turns freely",
              kOthers);
  if (out.error_count() > errors) return false;
  plant.collocation = std::make_shared<CollocationSystem>(plant.system, *rule);
  plant.system = plant.collocation;
  return true;
}

void add_collocation_terms(const std::shared_ptr<const CollocationSystem>& system,
                           KnotModel& model) {
  model.add_constraint(
      make_constraint(kName, collocation_residual(system, model.ndx(), model.free_duration()),
                      ConstraintKind::bounds));
}

void write_collocation_parameters(const KnotModel& model, double dt, double* parameters) {
  const ConstraintTerm& term = model.constraints().back();
  parameters[term.parameters] = dt;
  std::fill_n(parameters + term.lower(), 2 * term.rows, 0.0);
  parameters[term.active()] = 1;
}

void guess_slopes(const CollocationSystem& system, const double* x, const double* next, double h,
                  double* w) {
  const System& inside = *system.inside();
  const auto data = inside.create_data(double{});
  const int n = system.ndx(), rows = system.rows(), top = n - rows;
  const auto slope = [&](const double* at, std::vector<double>& k) {
    inside.evaluate(at, w, *data);
    for (int i = 0; i < top; ++i) k[i] = at[top + i];
    std::copy_n(data->f.data(), rows, k.begin() + top);
  };
  std::vector<double> begin(n), end(n);
  slope(x, begin);
  slope(next, end);
  const int last = system.later_stages();
  std::copy_n(end.data() + top, rows, w + system.slopes(last));
  if (last == 1) return;
  std::vector<double> middle(n), k(n);
  for (int i = 0; i < n; ++i) middle[i] = 0.5 * (x[i] + next[i]) + h / 8 * (begin[i] - end[i]);
  slope(middle.data(), k);
  std::copy_n(k.data() + top, rows, w + system.slopes(1));
}

}  // namespace conddp
