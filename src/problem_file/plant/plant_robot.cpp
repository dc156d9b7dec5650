#include "problem_file/plant/plant_robot.hpp"

#include <algorithm>

#include <fmt/format.h>

#include "base/files/check_sums.hpp"
#include "base/text/spelling.hpp"
#include "systems/expressions/scope.hpp"

namespace conddp {
namespace {

UrdfOptions urdf_options(const RobotSpec& spec, const std::string& prefix,
                         const Vector3<double>& gravity) {
  UrdfOptions options;
  options.base = spec.base;
  for (const auto& [name, value] : spec.locked_joints) options.locked_joints[name.value] = value;
  // A payload mass that is a parameter is zero here; the parameter becomes a load.
  for (const PayloadSpec& payload : spec.payloads)
    options.payloads.push_back({payload.link.value, payload.mass, payload.com, payload.inertia});
  for (const auto& [name, value] : spec.rotor_inertia) options.rotor_inertia[name.value] = value;
  options.enforce_mimic = spec.enforce_mimic;
  options.inertias = spec.inertias;
  options.gravity = gravity;
  options.prefix = prefix;
  if (spec.placement) options.placement = spec.placement->placement();
  return options;
}

/// Place in the problem file of a link or joint from a URDF error. If several names with `*` fit a
/// joint, the place of the best fit.
Place place_of(const RobotSpec& spec, const std::string& element) {
  const Name* best = nullptr;
  std::size_t quality = 0;
  for (const NamedNumbers* numbers : {&spec.locked_joints, &spec.rotor_inertia})
    for (const auto& [name, value] : *numbers)
      if (const std::size_t found = fit(name.value, element); found > quality) {
        quality = found;
        best = &name;
      }
  for (const PayloadSpec& payload : spec.payloads)
    if (payload.link.value == element) return payload.link.place;
  return best != nullptr ? best->place : spec.urdf.place;
}

/// The joints that 'full' drives. A base has no motors; a planar base is the first three joints.
std::vector<int> motor_joints(const PlantPart& part, const RobotModel& model) {
  std::vector<int> list;
  const int first = part.spec->base == UrdfOptions::Base::planar ? 3 : 0;
  for (int joint = part.first_joint + first; joint < part.first_joint + part.joint_count; ++joint)
    if (is_independent(model, joint)) list.push_back(joint);
  return list;
}

/// Hint on giving controls to robots without actuators.
std::string actuation_hint(const std::vector<PlantPart>& parts, const RobotModel& model) {
  const auto any = [&](auto property) { return std::any_of(parts.begin(), parts.end(), property); };
  if (any([&](const PlantPart& part) { return !motor_joints(part, model).empty(); }))
    return "give 'actuation: full', joints or thrusters";
  const auto floats = std::ranges::find(model.joints, JointType::floating, &Joint::type);
  const std::string none =
      any([](const PlantPart& part) { return !part.spec->locked_joints.empty(); })
          ? "all joints are locked or fixed: "
      : floats != model.joints.end()
          ? fmt::format("'{}' floats and no other joint moves: ", floats->name)
          : "no joint moves: ";
  if (any([](const PlantPart& p) { return p.spec->base == UrdfOptions::Base::planar; }))
    return none +
           "'full' leaves out those of the planar base, name them in 'actuation: {joints: "
           "[...]}'";
  if (floats != model.joints.end())
    return none + "give 'actuation: {thrusters: [...]}', or 'actuation: none'";
  return none + "nothing is left to control; if this is intended, write 'actuation: none'";
}

/// Adds the file's own frames to a model.
void add_frames(const RobotSpec& spec, const std::string& prefix, RobotModel& model,
                Diagnostics& out) {
  for (const FrameSpec& frame : spec.frames) {
    if (model.find_frame(prefix + frame.name.value)) {
      out.error(frame.name.place,
                fmt::format("the robot has a frame '{}' already", frame.name.value));
      continue;
    }
    const auto found = find_frame(model, frame.parent, prefix, out);
    if (!found) continue;
    const Frame& parent = model.frames[*found];
    model.frames.push_back({.name = prefix + frame.name.value,
                            .joint = parent.joint,
                            .placement = parent.placement * frame.placement.placement()});
  }
}

}  // namespace

std::optional<RobotModel> load_robot(const RobotSpec& spec, const std::string& prefix,
                                     const Vector3<double>& gravity, std::string& sha256,
                                     Diagnostics& out) {
  UrdfResult result = load_urdf(spec.path, urdf_options(spec, prefix, gravity));
  sha256 = conddp::sha256(result.text);
  for (const UrdfProblem& problem : result.problems) {
    const Severity severity = problem.warning ? Severity::kWarning : Severity::kError;
    Diagnostic d{.severity = severity, .message = problem.message, .hint = problem.hint};
    if (problem.line > 0) {
      d.file = spec.path.string();
      d.line = problem.line;
      d.column = problem.column;
    } else {
      const Place place = place_of(spec, problem.element);
      d.path = place.path;
      d.source = place.mark.source;
      if (d.source >= 0) d.file = out.source_name(d.source);
      d.line = place.mark.line;
      d.column = place.mark.column;
    }
    out.add(std::move(d));
  }
  for (const std::string& note : result.notes)
    out.add({.file = spec.path.string(), .severity = Severity::kNote, .message = note});
  if (result.model) add_frames(spec, prefix, *result.model, out);
  return std::move(result.model);
}

void add_external_wrenches(const std::vector<PlantPart>& parts, RobotModel& model,
                           Diagnostics& out) {
  for (const PlantPart& part : parts)
    for (const WrenchSpec& wrench : part.spec->external_wrenches)
      if (const auto frame = find_frame(model, wrench.frame, part.prefix, out))
        model.wrenches.push_back({*frame, wrench.wrench});
}

namespace {

/// Adds parameters and loads to a model.
class ParameterBuilder {
 public:
  ParameterBuilder(RobotModel& model, Diagnostics& out) : model_(model), out_(out) {}

  void add(const PlantPart& part) {
    for (const auto& [name, start] : part.spec->parameters) add_parameter(name, start);
    for (const PayloadSpec& payload : part.spec->payloads)
      if (payload.mass_parameter) add_load(payload, part.prefix);
  }
  const std::vector<double>& starts() const { return starts_; }

 private:
  void add_parameter(const Name& name, double start) {
    const auto known = model_.find_joint(name.value);
    if (known && model_.joints[*known].type == JointType::parameter) {
      if (starts_[*known - first_] != start)
        out_.error(name.place, fmt::format("another robot starts the parameter '{}' at {}",
                                           name.value, starts_[*known - first_]));
      return;
    }
    if (!is_name_of_column(name)) return;
    model_.add_parameter(name.value);
    starts_.push_back(start);
  }

  /// True if a name is valid for a state column and not yet taken; reports an error otherwise.
  bool is_name_of_column(const Name& name) const {
    const int errors = out_.error_count();
    if (std::string defect = ExpressionScope().defect_of(name.value); !defect.empty())
      out_.error(name.place, std::move(defect));
    else if (std::ranges::find(kTaken, name.value) != std::end(kTaken) ||
             model_.find_joint(name.value) || model_.find_frame(name.value))
      out_.error(name.place, fmt::format("the robot has a name '{}' already", name.value),
                 "parameters have names that joints, links and columns of the state do not have");
    return out_.error_count() == errors;
  }

  void add_load(const PayloadSpec& payload, const std::string& prefix) {
    const Name& name = *payload.mass_parameter;
    const auto parameter = model_.find_joint(name.value);
    const auto link = model_.find_frame(prefix + payload.link.value);
    if (!parameter || !link) return;  // already reported
    if (const double start = starts_[*parameter - first_]; start < 0)
      out_.error(name.place, fmt::format("the mass '{}' starts at {} kg", name.value, start),
                 "masses are not negative");
    const Frame& frame = model_.frames[*link];
    if (frame.joint < 0) return;
    const Inertia<double> unit = inertia_about_origin(1.0, payload.com, Symmetric3<double>::zero());
    model_.loads.push_back({*parameter, frame.joint, act(frame.placement, unit)});
  }

  /// Names and groups of columns, and reserved names of expressions.
  static constexpr std::string_view kTaken[] = {"q", "v", "u", "t", "base", "previous"};

  RobotModel& model_;
  Diagnostics& out_;
  const int first_ = model_.joint_count();
  std::vector<double> starts_;
};

}  // namespace

std::vector<double> add_parameters(const std::vector<PlantPart>& parts, RobotModel& model,
                                   Diagnostics& out) {
  ParameterBuilder builder(model, out);
  for (const PlantPart& part : parts) builder.add(part);
  return builder.starts();
}

namespace {

/// Collects the controls of robots.
class Actuators {
 public:
  Actuators(const RobotModel& model, Diagnostics& out) : model_(model), out_(out) {}

  void add(const PlantPart& part) {
    const ActuationSpec& spec = part.spec->actuation;
    if (spec.full)
      for (const int joint : motor_joints(part, model_)) joints_.push_back(name_of(joint));
    for (const Name& name : spec.joints)
      for (const int joint : find_joints(model_, name, part.prefix, out_))
        if (!drives(name_of(joint))) joints_.push_back(name_of(joint));
    for (const ThrusterSpec& thruster : spec.thrusters) add_thruster(thruster, part);
  }
  const std::vector<Thruster>& thrusters() const { return thrusters_; }
  const std::vector<std::string>& joints() const { return joints_; }

 private:
  const std::string& name_of(int joint) const { return model_.joints[joint].name; }
  bool drives(const std::string& joint) const {
    return std::find(joints_.begin(), joints_.end(), joint) != joints_.end();
  }
  bool has_thruster(const std::string& name) const {
    return std::any_of(thrusters_.begin(), thrusters_.end(),
                       [&](const Thruster& thruster) { return thruster.name == name; });
  }
  void add_thruster(const ThrusterSpec& t, const PlantPart& part) {
    const std::string name = part.prefix + t.name.value;
    const auto frame = find_frame(model_, t.frame, part.prefix, out_);
    if (!frame) return;
    const int joint = model_.frames[*frame].joint;
    if (joint < 0 || model_.joints[joint].type != JointType::floating)
      out_.error(t.frame.place, fmt::format("the thruster's frame '{}' is not fixed to a floating "
                                            "base",
                                            t.frame.value));
    if (has_thruster(name) || drives(name))
      out_.error(t.name.place, fmt::format("two controls have the name '{}'", t.name.value));
    thrusters_.push_back({name, *frame, t.direction, t.torque_ratio, t.lower, t.upper});
  }

  const RobotModel& model_;
  Diagnostics& out_;
  std::vector<Thruster> thrusters_;
  std::vector<std::string> joints_;
};

}  // namespace

std::optional<Actuation> make_actuation(const std::vector<PlantPart>& parts,
                                        const RobotModel& model, Diagnostics& out) {
  const int errors = out.error_count();
  Actuators actuators(model, out);
  for (const PlantPart& part : parts) actuators.add(part);
  if (out.error_count() > errors) return std::nullopt;
  const bool meant =
      std::ranges::none_of(parts, [](const PlantPart& part) { return part.spec->actuation.full; });
  if (actuators.thrusters().empty() && actuators.joints().empty() && !meant) {
    out.error(parts.front().spec->place, "nothing is actuated", actuation_hint(parts, model));
    return std::nullopt;
  }
  return Actuation::thrusters(model, actuators.thrusters(), actuators.joints());
}

namespace {

/// Clears the damping and friction of joints if the file does not enable them.
void ignore_others(const PlantPart& part, RobotModel& model) {
  const PassiveSpec& passive = part.spec->passive;
  for (int i = part.first_joint; i < part.first_joint + part.joint_count; ++i) {
    if (!passive.damping) model.joints[i].damping = 0;
    if (!passive.friction) model.joints[i].friction = 0;
  }
}

}  // namespace

std::optional<PassiveForces> make_passive_forces(const std::vector<PlantPart>& parts,
                                                 RobotModel& model, Diagnostics& out) {
  PassiveForces forces;
  for (const PlantPart& part : parts) {
    const PassiveSpec& passive = part.spec->passive;
    ignore_others(part, model);
    if (forces.friction && passive.friction &&
        passive.friction_velocity != forces.friction_velocity) {
      out.error(part.spec->place, "robots of one problem share one 'friction_velocity'");
      return std::nullopt;
    }
    forces.damping |= passive.damping;
    if (passive.friction) forces.friction_velocity = passive.friction_velocity;
    forces.friction |= passive.friction;
  }
  return forces;
}

}  // namespace conddp
