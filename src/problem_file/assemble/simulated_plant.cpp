#include "problem_file/assemble/simulated_plant.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

#include <fmt/format.h>

#include "analysis/contact/simulated_contacts.hpp"
#include "problem_file/motion/swing_arc.hpp"
#include "problem_file/plant/stepping_builder.hpp"

namespace conddp {
namespace {

/// All candidate contact points, and the contact of each.
struct Candidates {
  ImplicitContacts contacts;
  std::vector<int> contact_of;
};

/// Candidates of contact-implicit steps, but those against the world touch the plant's ground.
Candidates candidates_of(const SteppingSystem& system, const std::vector<TouchedSpec>& ground) {
  Candidates all{system.contacts(), {}};
  all.contacts.candidates.clear();
  const std::vector<ContactCandidate>& own = system.contacts().candidates;
  for (std::size_t i = 0; i < own.size(); ++i) {
    const auto add = [&](decltype(ContactCandidate::against) against) {
      ContactCandidate& candidate = all.contacts.candidates.emplace_back(own[i]);
      candidate.against = std::move(against);
      all.contact_of.push_back(static_cast<int>(i));
    };
    const bool carried =
        std::visit([](const auto& shape) { return shape.frame >= 0; }, own[i].against);
    if (carried || own[i].sphere.frame < 0)
      add(own[i].against);
    else
      for (const TouchedSpec& shape : ground) add(touched_form(shape, -1));
  }
  return all;
}

Candidates candidates_of(const ProblemSpec& spec, const Plant& plant, Diagnostics& out) {
  if (const auto stepping = plant.stepping())
    return candidates_of(*stepping, spec.mpc->plant.ground);
  Candidates all;
  for (std::size_t i = 0; i < spec.contacts.size(); ++i) {
    const ContactSpec& contact = spec.contacts[i];
    const auto frame = find_frame(plant.robot(), contact.frame, "", out);
    if (!frame) continue;
    for (const TouchedSpec& shape : spec.mpc->plant.ground)
      for (const Vector3<double>& point : contact_points(contact)) {
        all.contacts.candidates.push_back({.name = contact.name.value,
                                           .sphere = {*frame, point, 0},
                                           .against = touched_form(shape, -1),
                                           .friction = contact.friction});
        all.contact_of.push_back(static_cast<int>(i));
      }
  }
  return all;
}

bool has_mimic_joints(const RobotModel& robot) { return !robot.mimics.empty(); }

/// Checks the requirements of a plant with simulated contacts; false, with a report, if one fails.
bool check(const ProblemSpec& spec, const BuiltProblem& built, Diagnostics& out) {
  const MpcPlantSpec& plant = spec.mpc->plant;
  const int errors = out.error_count();
  if (built.plant.multibody() == nullptr || (spec.contacts.empty() && spec.candidates.empty()))
    out.error(*plant.simulated_contacts, "the file has no contacts that could be simulated",
              "leave the key out");
  else if (const auto held = std::ranges::find_if(
               spec.contacts, [](const ContactSpec& contact) { return contact.to.has_value(); });
           held != spec.contacts.end())
    out.error(
        *plant.simulated_contacts,
        fmt::format("the simulation knows contacts with the ground, and '{}' holds two frames "
                    "together",
                    held->name.value));
  else if (has_mimic_joints(built.plant.robot()))
    out.error(
        *plant.simulated_contacts,
        "the simulation of contacts moves each joint by its own equation, and some mimic others");
  if (std::max(spec.contacts.size(), spec.candidates.size()) > kMostSimulatedContacts)
    out.error(*plant.simulated_contacts,
              fmt::format("more than {} contacts are not simulated", kMostSimulatedContacts));
  if (!plant.dt)
    out.error(*plant.simulated_contacts, "simulated contacts need the step of the plant",
              "write 'dt: 0.002' beside it");
  return out.error_count() == errors;
}

}  // namespace

std::shared_ptr<PlantMotion> simulated_plant(const BuiltProblem& built, Diagnostics& out) {
  const ProblemSpec& spec = *built.problem_spec;
  if (!check(spec, built, out)) return nullptr;
  const MultibodySystem& robot = *built.plant.multibody();
  const int errors = out.error_count();
  Candidates candidates = candidates_of(spec, built.plant, out);
  if (out.error_count() > errors) return nullptr;
  const int remembered = built.problem->nx() - robot.nx();
  return std::make_shared<SimulatedContacts>(contact_plant(robot, std::move(candidates.contacts)),
                                             spec.mpc->plant.dt->value,
                                             std::move(candidates.contact_of), remembered);
}

void check_standing(const BuiltProblem& built, Diagnostics& out) {
  const ProblemSpec& spec = *built.problem_spec;
  constexpr double kAtTheGround = 2e-3;  // m
  const ContactNames& standing = spec.phases.front().contacts;
  const Candidates candidates = candidates_of(spec, built.plant, out);
  const MultibodySystem& robot = *built.plant.multibody();
  const std::vector<double> x(built.problem->initial_state().begin(),
                              built.problem->initial_state().begin() + robot.nx());
  const ContactPlant plant = contact_plant(robot, candidates.contacts);
  ContactMechanics<double> mechanics(plant);
  const auto& instants = mechanics.look(x.data());
  for (std::size_t i = 0; i < spec.contacts.size(); ++i) {
    const std::string& name = spec.contacts[i].name.value;
    const bool stands = standing.has(name);
    double gap = std::numeric_limits<double>::infinity();
    for (std::size_t c = 0; c < instants.size(); ++c)
      if (candidates.contact_of[c] == static_cast<int>(i)) gap = std::min(gap, instants[c].gap);
    if (gap < -kAtTheGround || (stands && gap > kAtTheGround))
      out.warning(*spec.mpc->plant.simulated_contacts,
                  fmt::format("'{}' begins {:.3g} m {} the ground", name, std::abs(gap),
                              gap < 0 ? "inside" : "above"));
  }
}

}  // namespace conddp
