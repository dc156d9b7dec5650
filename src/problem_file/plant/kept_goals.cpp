#include "problem_file/plant/kept_goals.hpp"

#include <algorithm>
#include <limits>

#include "problem_file/model/residual_keys.hpp"
#include "problem_file/plant/shape_pairs.hpp"

namespace conddp {
namespace {

void add_pairs(const CostSpec& term, const ProblemSpec& spec, const Plant& plant,
               std::vector<PostureGoal>& goals) {
  if (term.definition == nullptr || term.definition->name != "distance") return;
  Diagnostics own;
  const double margin = term.keys.value(key::margin);
  std::vector<DistancePair> shapes;
  for (const ShapePair& pair : shape_pairs(term, spec, plant, own)) {
    shapes.push_back(pair.shapes);
    shapes.back().margin = margin;
  }
  if (shapes.empty() || own.has_errors()) return;
  goals.push_back({distance_residual(plant.multibody(), shapes),
                   {},
                   margin,
                   std::numeric_limits<double>::infinity()});
}

std::vector<PostureGoal> distances(const ProblemSpec& spec, const Plant& plant) {
  std::vector<PostureGoal> goals;
  Diagnostics own;
  check_shapes(spec, plant, own);
  if (own.has_errors()) return goals;
  for (const auto* costs : {&spec.costs, &spec.terminal_costs})
    for (const CostSpec& cost : *costs) add_pairs(cost, spec, plant, goals);
  for (const auto* constraints : {&spec.constraints, &spec.terminal_constraints})
    for (const ConstraintSpec& c : *constraints) add_pairs(c.function, spec, plant, goals);
  return goals;
}

}  // namespace

Contact contact_of(const ContactSpec& spec, int frame, std::optional<int> base) {
  Contact contact{.name = spec.name.value,
                  .frame = frame,
                  .base = base,
                  .kind = spec.kind,
                  .axes = spec.axes,
                  .normal = spec.normal,
                  .tangent = spec.tangent.value_or(Vector3<double>{1, 0, 0}),
                  .kp = spec.kp,
                  .kd = spec.kd};
  if (spec.placement) contact.reference = spec.placement->placement();
  return contact;
}

KeptGoals kept_goals(const ProblemSpec& spec, const Plant& plant) {
  const RobotModel& robot = plant.robot();
  std::vector<Contact> loops;
  for (const ContactSpec& contact : spec.contacts) {
    const auto holds = [&](const PhaseSpec& phase) {
      return phase.contacts.all || std::ranges::any_of(phase.contacts.names, [&](const Name& name) {
               return name.value == contact.name.value;
             });
    };
    if (!contact.to || !contact.placement || !std::ranges::all_of(spec.phases, holds)) continue;
    const auto frame = robot.find_frame(contact.frame.value);
    const auto base = robot.find_frame(contact.to->value);
    if (!frame || !base || robot.frames[*frame].joint < 0 ||
        robot.frames[*frame].joint == robot.frames[*base].joint)
      continue;
    loops.push_back(contact_of(contact, *frame, *base));
  }
  const std::shared_ptr<const MultibodySystem> system = plant.multibody();
  return {loops.empty() ? system : system->with_contacts(std::move(loops)), distances(spec, plant)};
}

}  // namespace conddp
