#include "problem_file/motion/state_builder.hpp"

#include <algorithm>
#include <cmath>

#include <fmt/format.h>

#include "base/text/spelling.hpp"
#include "problem_file/motion/placed_frames.hpp"
#include "problem_file/motion/planar_motion.hpp"
#include "problem_file/plant/joint_values.hpp"
#include "systems/system.hpp"

namespace conddp {
namespace {

/// Allowed rounding of joint limits, relative to the position or 1.
constexpr double kLimitRounding = 1e-9;

/// True if a state has keys that only robots support.
bool speaks_of_robots(const StateSpec& spec) {
  return spec.configuration || spec.base || spec.displaced || !spec.joints.empty() ||
         !spec.frames.empty() || spec.base_velocity || !spec.joint_velocities.empty() ||
         !spec.robots.empty();
}

bool is_outside(const Joint& joint, double q) {
  const double slack = kLimitRounding * std::max(1.0, std::abs(q));
  return !(q >= joint.lower - slack && q <= joint.upper + slack);
}

void warn_of_limits(std::string_view subject, const Joint& joint, double q, const Place& place,
                    Diagnostics& out) {
  const bool turns = joint.type == JointType::revolute;
  std::string hint;
  if (turns && std::abs(q) > 2 * M_PI)
    hint = fmt::format("angles are in rad: {0:.6g}° is {1:.4g} rad", q, q * M_PI / 180);
  out.warning(
      place,
      fmt::format("{} has the joint '{}' at {:.6g} {}, outside of its limits, {:.6g} to {:.6g}",
                  subject, joint.name, q, turns ? "rad" : "m", joint.lower, joint.upper),
      hint);
}

/// Sets position and orientation of a floating base; x points to its entries in the state.
void set_floating_base(const BaseSpec& base, double* x) {
  for (int i = 0; i < 3 && base.position; ++i) x[i] = (*base.position)[i];
  if (const auto& q = base.orientation) {
    const double parts[] = {q->x, q->y, q->z, q->w};
    std::copy_n(parts, 4, x + 3);
  }
}

}  // namespace

StateBuilder::StateBuilder(const Plant& plant, Diagnostics& out) : plant_(plant), out_(out) {}

PlantPart StateBuilder::whole() const {
  if (plant_.parts.size() == 1) return plant_.parts.front();
  return {nullptr, "", 0, plant_.robot().joint_count()};
}

std::optional<std::vector<double>> StateBuilder::build(const StateSpec& spec) const {
  const System& system = *plant_.system;
  const int errors = out_.error_count();
  std::vector<double> x = usual_state();
  if (spec.state && !apply_list(*spec.state, x)) {
    const ComponentNames names = state_names(system).listed();
    out_.error(spec.place,
               fmt::format("the state has {}, not {}", counted(names.size(), "number"),
                           spec.state->size()),
               list_of(names));
    return std::nullopt;
  }
  apply_columns(spec.values, x);
  if (plant_.multibody()) {
    apply(spec, whole(), x);
    place(spec, errors, x);
  } else if (speaks_of_robots(spec)) {
    out_.error(spec.place, "a closed-form system has no configurations, base or joints",
               "write 'values: {column: number}' or 'state: [numbers]'");
  }
  if (out_.error_count() > errors) return std::nullopt;
  return checked(std::move(x), spec.values.empty() ? spec.place : spec.values.back().first.place);
}

bool StateBuilder::apply_list(const std::vector<double>& list, std::vector<double>& x) const {
  if (list.size() == x.size()) {
    x = list;
    return true;
  }
  const std::vector<int> states = own_states(*plant_.system);
  if (list.size() != states.size()) return false;
  for (std::size_t i = 0; i < list.size(); ++i) x[states[i]] = list[i];
  return true;
}

std::vector<double> StateBuilder::usual_state() const {
  return plant_.usual_state.empty() ? plant_.system->manifold().neutral() : plant_.usual_state;
}

std::optional<std::vector<double>> StateBuilder::checked(std::vector<double> x,
                                                         const Place& place) const {
  if (plant_.system->manifold().normalize(x.data())) return x;
  out_.error(place, "a quaternion of the state does not have length 1", "the order is x, y, z, w");
  return std::nullopt;
}

bool StateBuilder::check_limits(std::string_view subject, const std::vector<double>& x,
                                const std::function<Place(const std::string&)>& place_of) const {
  if (!plant_.multibody()) return false;
  bool outside = false;
  for (int i = 0; i < plant_.robot().joint_count(); ++i) {
    const Joint& joint = plant_.robot().joints[i];
    const auto index = plant_.multibody()->position_index(i);
    if (joint.type == JointType::floating || !index || std::isnan(x[*index])) continue;
    if (!is_outside(joint, x[*index])) continue;
    outside = true;
    warn_of_limits(subject, joint, x[*index], place_of(joint.name), out_);
  }
  return outside;
}

std::optional<std::vector<double>> StateBuilder::named(const Name& name) const {
  if (name.value == "initial" && !initial_.empty()) return initial_;
  const int errors = out_.error_count();
  std::vector<double> x = usual_state();
  if (plant_.multibody()) {
    apply_configuration(name, whole(), x);
    place({.place = name.place, .configuration = name}, errors, x);
  } else {
    out_.error(name.place, fmt::format("unknown state '{}'", name.value),
               "a closed-form system has the name 'initial' only");
  }
  if (out_.error_count() > errors) return std::nullopt;
  return checked(std::move(x), name.place);
}

void StateBuilder::place(const StateSpec& spec, int errors, std::vector<double>& x) const {
  if (out_.error_count() > errors) return;
  const std::vector<WantedFrame> frames = wanted_frames(spec, whole(), plant_);
  if (!frames.empty()) place_frames(frames, plant_, x, out_);
}

void StateBuilder::apply_columns(const NamedNumbers& values, std::vector<double>& x) const {
  const ComponentNames names = state_names(*plant_.system);
  for (const auto& [name, value] : values) {
    const auto found = std::find(names.names.begin(), names.names.end(), name.value);
    if (found != names.names.end())
      x[found - names.names.begin()] = value;
    else
      out_.error(name.place, fmt::format("the state has no column '{}'", name.value),
                 name_hint(name.value, names.names, "columns"));
  }
}

void StateBuilder::apply(const StateSpec& spec, const PlantPart& part,
                         std::vector<double>& x) const {
  if (spec.configuration) apply_configuration(*spec.configuration, part, x);
  if (spec.base) apply_base(*spec.base, part, x);
  if (spec.base_velocity) apply_base_velocity(*spec.base_velocity, part, x);
  apply_joints(spec, part, x);
  if (spec.displaced) apply_displacement(*spec.displaced, part, x);
  for (const NamedState& part_spec : spec.robots) apply_part(part_spec, x);
}

void StateBuilder::apply_joints(const StateSpec& spec, const PlantPart& part,
                                std::vector<double>& x) const {
  const RobotModel& robot = plant_.robot();
  const MultibodySystem& system = *plant_.multibody();
  for (const auto& [joint, value] : values_of_joints(robot, spec.joints, part.prefix, out_))
    x[*system.position_index(joint)] = value;
  for (const auto& [joint, value] :
       values_of_joints(robot, spec.joint_velocities, part.prefix, out_))
    x[*system.velocity_index(joint)] = value;
}

void StateBuilder::apply_part(const NamedState& part, std::vector<double>& x) const {
  const StateSpec& state = part.state;
  const PlantPart* found = find_part(part.name);
  if (found == nullptr) return;
  if (state.state || !state.values.empty())
    out_.error(state.place, "here a robot's state is given by configuration, base and joints");
  apply(state, *found, x);
}

const PlantPart* StateBuilder::find_part(const Name& name) const {
  const auto found =
      std::find_if(plant_.parts.begin(), plant_.parts.end(),
                   [&](const PlantPart& p) { return p.spec->name.value == name.value; });
  if (found != plant_.parts.end() && !name.value.empty()) return &*found;
  std::vector<std::string> robots;
  for (const PlantPart& p : plant_.parts) robots.push_back(p.spec->name.value);
  out_.error(name.place, fmt::format("unknown robot '{}'", name.value),
             plant_.parts.size() == 1 ? "the problem has one robot: leave 'robots' out"
                                      : name_hint(name.value, robots, "robots"));
  return nullptr;
}

void StateBuilder::apply_configuration(const Name& name, const PlantPart& part,
                                       std::vector<double>& x) const {
  std::vector<std::string> known;
  for (const PlantPart& candidate : plant_.parts) {
    if (part.spec != nullptr && candidate.spec != part.spec) continue;
    const std::string prefix = part.spec != nullptr ? "" : candidate.prefix;
    for (const auto& [configuration, state] : candidate.spec->configurations) {
      if (prefix + configuration.value == name.value) return apply(state, candidate, x);
      known.push_back(prefix + configuration.value);
    }
  }
  out_.error(name.place, fmt::format("unknown configuration '{}'", name.value),
             name_hint(name.value, known, "configurations"));
}

void StateBuilder::apply_base(const BaseSpec& base, const PlantPart& part,
                              std::vector<double>& x) const {
  if (part.spec == nullptr)
    return out_.error(base.place, "with several robots a base is given under 'robots'",
                      "write 'robots: {name: {base: ...}}'");
  if (part.spec->base == UrdfOptions::Base::planar) return apply_planar_base(base, part, x);
  if (!floats(part))
    return out_.error(
        base.place, "the robot's base is fixed",
        "write 'base: floating' under 'robot', or use 'placement' to put it elsewhere");
  if (base.position && base.position->size() != 3)
    return out_.error(base.place,
                      "a floating base has 'position: [x, y, z]' and 'orientation' or 'rpy'");
  set_floating_base(base, x.data() + *plant_.multibody()->position_index(part.first_joint));
}

bool StateBuilder::floats(const PlantPart& part) const {
  return part.joint_count > 0 &&
         plant_.robot().joints[part.first_joint].type == JointType::floating;
}

void StateBuilder::apply_planar_base(const BaseSpec& base, const PlantPart& part,
                                     std::vector<double>& x) const {
  if (base.orientation || (base.position && base.position->size() != 2))
    return out_.error(base.place, "a planar base has 'position: [x, y]', and the joint 'base_yaw'");
  const MultibodySystem& system = *plant_.multibody();
  const int joint = part.first_joint;
  for (int i = 0; i < 2 && base.position; ++i)
    x[*system.position_index(joint + i)] = (*base.position)[i];
}

void StateBuilder::apply_displacement(const DisplacementSpec& displaced, const PlantPart& part,
                                      std::vector<double>& x) const {
  if (displaced.with_gait)
    out_.error(displaced.place,
               "'gait' is the path of the file's gait, and only valid as the whole reference of a "
               "cost on the state",
               "give '[x, y, yaw]' in m and rad");
  else if (part.spec == nullptr)
    out_.error(displaced.place, "with several robots a displacement is given under 'robots'");
  else if (!displace_base(plant_, part, displaced.motion, x))
    out_.error(displaced.place, "the robot's base is fixed: it cannot be displaced");
}

void StateBuilder::apply_base_velocity(const TwistSpec& twist, const PlantPart& part,
                                       std::vector<double>& x) const {
  if (part.spec == nullptr)
    return out_.error(twist.place, "with several robots a velocity is given under 'robots'");
  if (part.spec->base == UrdfOptions::Base::planar)
    return apply_planar_velocity(twist, part.first_joint, x);
  if (!floats(part)) return out_.error(twist.place, "the robot's base is fixed");
  const int first = *plant_.multibody()->velocity_index(part.first_joint);
  for (int i = 0; i < 3; ++i) {
    x[first + i] = twist.linear[i];
    x[first + 3 + i] = twist.angular[i];
  }
}

void StateBuilder::apply_planar_velocity(const TwistSpec& twist, int joint,
                                         std::vector<double>& x) const {
  if (twist.linear.z != 0 || twist.angular.x != 0 || twist.angular.y != 0)
    return out_.error(twist.place, "a planar base moves along x and y and turns about z");
  const MultibodySystem& system = *plant_.multibody();
  x[*system.velocity_index(joint)] = twist.linear.x;
  x[*system.velocity_index(joint + 1)] = twist.linear.y;
  x[*system.velocity_index(joint + 2)] = twist.angular.z;
}

}  // namespace conddp
