#include "ocp/problem/node_values.hpp"

#include <algorithm>
#include <cmath>

#include "ocp/terms/constraint.hpp"
#include "systems/multibody/multibody.hpp"

namespace conddp {
namespace {

/// Evaluates the contacts of systems at a knot's state and control if the knot's step evaluates the
/// system elsewhere.
class ContactEvaluation {
 public:
  const SystemData<double>& at(const MultibodySystem& robot, const double* x, const double* u) {
    auto& data = data_[&robot];
    if (!data) data = robot.create_data(double{});
    robot.evaluate(x, u, *data);
    return *data;
  }

 private:
  std::map<const MultibodySystem*, std::unique_ptr<SystemData<double>>> data_;
};

std::vector<HeldContact> held_contacts(const SystemData<double>& data) {
  const auto& found = static_cast<const MultibodySystem::Data<double>&>(data).contacts.contacts;
  std::vector<HeldContact> held;
  held.reserve(found.size());
  for (const ContactData<double>& contact : found)
    held.push_back({contact.world, contact.relative, contact_force_in_world(contact)});
  return held;
}

}  // namespace

KnotInput<double> NodeEvaluation::input(int node, const double* x, const double* u) const {
  const KnotView& view = problem_.knot(node);
  return {x, u, view.parameters, view.dt, view.cost_scale};
}

KnotWorkspace<double>& NodeEvaluation::workspace(const KnotModel& model) {
  auto& work = work_[&model];
  if (!work) work = std::make_unique<KnotWorkspace<double>>(model);
  return *work;
}

const KnotWorkspace<double>& NodeEvaluation::at(int node, const double* x, const double* u) {
  const KnotModel& model = *problem_.knot(node).model;
  KnotWorkspace<double>& work = workspace(model);
  model.evaluate(input(node, x, u), work);
  return work;
}

const KnotWorkspace<double>& NodeEvaluation::derivatives_at(int node, const double* x,
                                                            const double* u) {
  const KnotModel& model = *problem_.knot(node).model;
  KnotWorkspace<double>& work = workspace(model);
  model.differentiate(input(node, x, u), work, false);
  return work;
}

const KnotWorkspace<double>& NodeEvaluation::at(int node, const Trajectory& trajectory) {
  const double* u = node < problem_.knots() ? trajectory.u(node).data() : nullptr;
  return at(node, trajectory.x(node).data(), u);
}

NodeValues::NodeValues(const ShootingProblem& problem, const Trajectory& trajectory)
    : trajectory_(trajectory),
      first_cost_(1, 0),
      first_soft_(1, 0),
      constraint_(problem.constraint_rows()),
      next_(problem.nx(), problem.knots()),
      contacts_(problem.knots()) {
  NodeEvaluation nodes(problem);
  ContactEvaluation contacts;
  for (int k = 0; k <= problem.knots(); ++k) {
    const KnotWorkspace<double>& work = nodes.at(k, trajectory);
    term_costs_.insert(term_costs_.end(), work.term_costs.begin(), work.term_costs.end());
    first_cost_.push_back(term_costs_.size());
    const KnotView& view = problem.knot(k);
    for (const ConstraintTerm& term : view.model->constraints())
      soft_costs_.push_back(
          term.softness == Softness::hard
              ? 0
              : soft_cost(term, work.constraint.data() + term.row, view.parameters,
                          view.model->soft_scale(term, view.cost_scale, trajectory.x(k).data())));
    first_soft_.push_back(soft_costs_.size());
    std::copy(work.constraint.begin(), work.constraint.end(),
              constraint_.data() + problem.constraint_offset(k));
    if (k == problem.knots()) break;
    std::copy_n(work.next().begin(), problem.nx(), next_.col(k).data());
    const MultibodySystem* robot = view.model->system().as_multibody();
    if (robot == nullptr || robot->contacts().empty()) continue;
    contacts_[k] =
        held_contacts(is_structured(view.model->integrator())
                          ? work.system()
                          : contacts.at(*robot, trajectory.x(k).data(), trajectory.u(k).data()));
  }
}

bool NodeValues::all_finite() const {
  return constraint_.allFinite() && next_.allFinite() &&
         std::ranges::all_of(term_costs_, [](double cost) { return std::isfinite(cost); });
}

}  // namespace conddp
