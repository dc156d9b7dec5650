#include "problem_file/first_problem/robot_survey.hpp"

#include <algorithm>
#include <array>
#include <cctype>
#include <cmath>

#include <fmt/format.h>
#include <fmt/ranges.h>

#include "base/json/ordered_json.hpp"
#include "problem_file/motion/state_builder.hpp"
#include "problem_file/plant/plant_builder.hpp"
#include "problem_file/read/read_problem.hpp"
#include "robot/frames.hpp"
#include "robot/urdf/regularity.hpp"

namespace conddp {
namespace {

std::string lower_case(std::string text) {
  for (char& c : text) c = static_cast<char>(std::tolower(static_cast<unsigned char>(c)));
  return text;
}

/// Files of this suffix in a folder, in the order of their names.
std::vector<std::filesystem::path> files_in(const std::filesystem::path& folder,
                                            const std::string& suffix) {
  std::vector<std::filesystem::path> files;
  std::error_code ignored;
  for (const auto& entry : std::filesystem::directory_iterator(folder, ignored))
    if (entry.path().extension() == suffix) files.push_back(entry.path());
  std::ranges::sort(files);
  return files;
}

/// The SRDF of a URDF: in its folder or in `srdf` beside that, with its name or the beginning of
/// its name. The longest common name wins.
std::filesystem::path srdf_beside(const std::filesystem::path& urdf) {
  const std::string name = lower_case(urdf.stem().string());
  std::filesystem::path best;
  std::size_t length = 0;
  for (const char* folder : {".", "../srdf"})
    for (const auto& file : files_in(urdf.parent_path() / folder, ".srdf")) {
      const std::string stem = lower_case(file.stem().string());
      if (!name.starts_with(stem) || stem.size() <= length) continue;
      length = stem.size();
      best = file.lexically_normal();
    }
  return best;
}

/// Joints that no inertia resists, which are to be locked.
NamedNumbers locked_joints(const std::filesystem::path& urdf, UrdfOptions::Base base) {
  NamedNumbers locked;
  const auto lock = [&](const Joint& joint) {
    locked.emplace_back(Name{joint.name, {}}, zero_position(joint));
  };
  // With rotors, the robot can be loaded; without them, its defects appear.
  for (bool more = true; more;) {
    more = false;
    UrdfOptions options{.base = base, .rotor_inertia = {{"*", 1.0}}};
    for (const auto& [name, value] : locked) options.locked_joints[name.value] = value;
    UrdfResult rest = load_urdf(urdf, options);
    if (!rest.model) break;
    for (Joint& joint : rest.model->joints) joint.rotor_inertia = 0;
    for (const auto& found :
         {joints_without_inertia(*rest.model), joints_without_inertia_at_zero(*rest.model),
          joints_with_negative_inertia(*rest.model)}) {
      for (const int joint : found)
        if (rest.model->joints[joint].type != JointType::floating) {
          lock(rest.model->joints[joint]);
          more = true;
        }
      if (more) break;
    }
  }
  return locked;
}

/// The text of a problem with the robot alone.
std::string draft_text(const RobotSurvey& survey, bool actuated) {
  std::vector<std::string> locked;
  for (const auto& [name, value] : survey.locked)
    locked.push_back(fmt::format("{}: {}", yaml_name(name.value), value));
  std::string robot = fmt::format(
      "urdf: {}, base: {}, locked_joints: {{{}}}", yaml_name(survey.urdf.string()),
      survey.base == UrdfOptions::Base::fixed ? "fixed" : "floating", fmt::join(locked, ", "));
  if (!survey.srdf.empty()) robot += ", srdf: " + yaml_name(survey.srdf.string());
  if (!actuated) robot += ", actuation: none";
  return fmt::format(
      "conddp: 1\nrobot: {{{}}}\ninitial_state: {{}}\nphases: [{{knots: 1, dt: 0.1}}]\n"
      "costs: {{state: {{residual: state}}}}\n",
      robot);
}

/// The group state that is most likely a posture at rest.
const StateSpec* rest_posture(const RobotSpec& robot, std::string& name) {
  for (const char* word : {"stand", "sit", "home", "homing", "default", "neutral", "ready", "up"})
    for (const auto& [own, state] : robot.configurations)
      if (lower_case(own.value).find(word) != std::string::npos) {
        name = own.value;
        return &state;
      }
  return nullptr;
}

/// Loads the plant and sets the posture. An SRDF that does not fit is ignored.
bool load_plant(RobotSurvey& survey, Diagnostics& out) {
  UrdfOptions options{.base = survey.base};
  for (const auto& [name, value] : survey.locked) options.locked_joints[name.value] = value;
  const UrdfResult file = load_urdf(survey.urdf, options);
  const bool actuated = !file.model || std::ranges::any_of(file.model->joints, [](const Joint& j) {
    return j.type != JointType::floating;
  });
  Diagnostics of_srdf;
  Diagnostics& log = survey.srdf.empty() ? out : of_srdf;
  const auto spec = read_problem_text(draft_text(survey, actuated), "draft.yaml", {}, log);
  auto plant = spec ? build_plant(*spec, log) : std::nullopt;
  std::optional<std::vector<double>> x;
  if (plant) {
    survey.plant = std::move(*plant);
    const StateSpec* posture = rest_posture(spec->robots.front(), survey.posture);
    x = StateBuilder(survey.plant, log).build(posture != nullptr ? *posture : StateSpec{});
  }
  if (!x && !survey.srdf.empty()) {
    survey.srdf.clear();
    survey.posture.clear();
    return load_plant(survey, out);
  }
  if (!x) return false;
  survey.x = *x;
  const MultibodySystem& system = *survey.plant.multibody();
  for (const int joint : movable_joints(system, 0, system.robot().joint_count())) {
    const auto limits = given_limits(system, joint);
    double& q = survey.x[*system.position_index(joint)];
    q = std::max(limits.lower, std::min(limits.upper, q));
  }
  return true;
}

/// Distances along a robot's branches.
class Branches {
 public:
  explicit Branches(const RobotModel& robot) : robot_(robot), children_(robot.joint_count(), 0) {
    for (int j = 0; j < robot.joint_count(); ++j)
      if (inner(j) >= 0) ++children_[inner(j)];
  }

  /// Joints without another one behind them.
  std::vector<int> ends() const {
    std::vector<int> ends;
    for (int j = 0; j < robot_.joint_count(); ++j)
      if (moves(j) && children_[j] == 0) ends.push_back(j);
    return ends;
  }
  /// All joints from the root to this one.
  std::vector<int> chain(int joint) const {
    std::vector<int> chain;
    for (; joint >= 0; joint = inner(joint)) chain.insert(chain.begin(), joint);
    return chain;
  }
  /// Joints of the chain that move this end alone.
  std::vector<int> own_chain(int end) const {
    std::vector<int> own;
    for (int joint = end; joint >= 0 && (joint == end || children_[joint] == 1);
         joint = inner(joint))
      own.insert(own.begin(), joint);
    return own;
  }
  bool branches(int joint) const { return children_[joint] > 1; }

 private:
  bool moves(int joint) const { return robot_.joints[joint].type != JointType::floating; }
  /// The joint before a joint, −1 at the root.
  int inner(int joint) const {
    const int parent = robot_.joints[joint].parent;
    return moves(joint) && parent >= 0 && moves(parent) ? parent : -1;
  }

  const RobotModel& robot_;
  std::vector<int> children_;
};

/// The link's frame on a joint's body that is farthest from the joint in a direction (a unit
/// vector), or at all if that is zero. `upright`: those with an axis z that points up come first.
int outermost_frame(const RobotModel& robot, const RobotData<double>& data, int joint,
                    const Vector3<double>& direction, bool upright) {
  const Vector3<double> origin = (data.root_pose(robot, joint) * data.placement[joint]).p;
  std::optional<int> best;
  double farthest = -kUnlimited;
  for (std::size_t i = 0; i < robot.frames.size(); ++i) {
    if (robot.frames[i].joint != joint || robot.frames[i].kind != FrameKind::link) continue;
    const SE3<double> pose = frame_placement(robot, data, static_cast<int>(i));
    const Vector3<double> p = pose.p - origin;
    const double distance =
        squared_norm(direction) > 0 ? dot(direction, p) : std::sqrt(squared_norm(p));
    if (upright && !is_upright(pose)) continue;
    // The shortest name wins among frames at one place, within the rounding of a file.
    constexpr double kSame = 1e-4;  // m
    const bool shorter = best && robot.frames[i].name.size() < robot.frames[*best].name.size();
    if (distance > farthest + kSame || (distance > farthest - kSame && shorter))
      farthest = distance, best = static_cast<int>(i);
  }
  if (best) return *best;
  return upright ? outermost_frame(robot, data, joint, direction, false)
                 : *robot.find_frame(robot.joints[joint].name);
}

/// The lowest tips under the root link: chains of two joints at least, from the root link to the
/// lowest tenth of the robot's height. Arms that hang begin behind a spine.
std::vector<Limb> find_feet(const RobotModel& robot, const RobotData<double>& data) {
  const Branches branches(robot);
  std::vector<Limb> limbs;
  double lowest = kUnlimited, highest = -kUnlimited;
  const auto height_of = [&](int frame) { return frame_placement(robot, data, frame).p.z; };
  for (std::size_t frame = 0; frame < robot.frames.size(); ++frame)
    highest = std::max(highest, height_of(static_cast<int>(frame)));
  for (const int end : branches.ends()) {
    if (branches.own_chain(end) != branches.chain(end)) continue;
    Limb& limb = limbs.emplace_back(Limb{branches.chain(end)});
    limb.tip = outermost_frame(robot, data, end, {0, 0, -1}, is_sole(limb));
    lowest = std::min(lowest, height_of(limb.tip));
  }
  const double tenth = (highest - lowest) / 10;
  std::erase_if(limbs, [&](const Limb& limb) {
    const double height = height_of(limb.tip);
    return limb.joints.size() < 2 || height > lowest + tenth || height > -tenth;
  });
  return limbs.size() < 2 ? std::vector<Limb>{} : limbs;
}

/// The longest chain.
Limb find_arm(const RobotModel& robot, const RobotData<double>& data) {
  const Branches branches(robot);
  std::vector<int> longest;
  for (const int end : branches.ends())
    if (const auto chain = branches.chain(end); chain.size() > longest.size()) longest = chain;
  if (longest.empty()) return {};
  return {longest, outermost_frame(robot, data, longest.back(), {0, 0, 0}, false)};
}

/// True for links named after rotors.
bool is_rotor(const Frame& frame) {
  const std::string name = lower_case(frame.name);
  return frame.kind == FrameKind::link &&
         std::ranges::any_of(std::array{"rotor", "prop", "thruster"}, [&](const char* word) {
           return name.find(word) != std::string::npos;
         });
}

bool has_rotor(const RobotModel& robot, int joint) {
  return std::ranges::any_of(
      robot.frames, [&](const Frame& frame) { return frame.joint == joint && is_rotor(frame); });
}

/// Locks fingers, wheels and rotors where they are. A hand begins where a chain branches, behind
/// the larger part of its joints and three at least, which place the hand. Wheels are behind as
/// many, with equal limits. Rotors turn on the root link, without effort.
void lock_ends(RobotSurvey& survey) {
  const RobotModel& robot = survey.plant.robot();
  const MultibodySystem& system = *survey.plant.multibody();
  const Branches branches(robot);
  std::vector<bool> locked(robot.joint_count(), false);
  for (const int end : branches.ends()) {
    const std::vector<int> chain = branches.chain(end);
    std::size_t hand = 3;
    while (hand < chain.size() && !(branches.branches(chain[hand - 1]) && 2 * hand > chain.size()))
      ++hand;
    const Joint& last = robot.joints[end];
    if (chain.size() > 3 && last.lower == last.upper) hand = std::min(hand, chain.size() - 1);
    if (chain.size() == 1 && last.max_effort == 0 && has_rotor(robot, end)) hand = 0;
    for (std::size_t i = hand; i < chain.size(); ++i) locked[chain[i]] = true;
  }
  for (int joint = 0; joint < robot.joint_count(); ++joint)
    if (locked[joint])
      survey.locked.emplace_back(Name{robot.joints[joint].name, {}},
                                 survey.x[*system.position_index(joint)]);
}

bool load_without_ends(RobotSurvey& survey, Diagnostics& out) {
  const std::size_t before = survey.locked.size();
  if (!load_plant(survey, out)) return false;
  lock_ends(survey);
  return survey.locked.size() == before || load_plant(survey, out);
}

std::vector<int> find_rotors(const RobotModel& robot) {
  std::vector<int> rotors;
  for (std::size_t i = 0; i < robot.frames.size(); ++i)
    if (const int joint = robot.frames[i].joint;
        joint >= 0 && robot.joints[joint].type == JointType::floating && is_rotor(robot.frames[i]))
      rotors.push_back(static_cast<int>(i));
  return rotors;
}

}  // namespace

MultibodySystem::JointLimits given_limits(const MultibodySystem& system, int joint) {
  auto limits = system.limits(joint);
  if (limits.lower == limits.upper) limits.lower = -kUnlimited, limits.upper = kUnlimited;
  return limits;
}

bool is_upright(const SE3<double>& pose) { return (pose.R * Vector3<double>{0, 0, 1}).z > 0.99; }

bool is_sole(const Limb& foot) {
  // Three joints place a foot, two more keep it flat.
  return foot.joints.size() >= 5;
}

std::string yaml_name(const std::string& name) {
  // Words that YAML 1.1 reads as other values than text.
  static constexpr std::string_view kOther[] = {"y",    "n",     "yes",  "no",  "on", "off",
                                                "true", "false", "null", "nan", "inf"};
  const bool letters = std::ranges::all_of(name, [](unsigned char c) {
    return std::isalnum(c) != 0 || c == '_' || c == '/' || c == '.' || c == '-';
  });
  const bool begins = !name.empty() && (std::isalpha(static_cast<unsigned char>(name[0])) != 0 ||
                                        name.starts_with("./") || name.starts_with("../"));
  const bool other = std::ranges::find(kOther, lower_case(name)) != std::end(kOther);
  return letters && begins && !other ? name : OrderedJson(name).dump();
}

std::optional<RobotSurvey> survey_robot(const std::filesystem::path& urdf, Diagnostics& out) {
  if (!std::filesystem::exists(urdf)) {
    out.error({}, fmt::format("'{}' does not exist", urdf.string()));
    return std::nullopt;
  }
  RobotSurvey survey{.urdf = urdf, .srdf = srdf_beside(urdf)};
  survey.base = UrdfOptions::Base::floating;
  survey.locked = locked_joints(urdf, survey.base);
  Diagnostics of_floating;
  if (load_without_ends(survey, of_floating)) {
    const RobotModel& robot = survey.plant.robot();
    std::vector<double> x = survey.x;
    std::copy_n(robot.neutral_configuration().begin(), 7, x.begin());
    const RobotData<double> data = data_in_state(*survey.plant.multibody(), x);
    survey.feet = find_feet(robot, data);
    survey.rotors = find_rotors(robot);
    survey.arm = find_arm(robot, data);
    if (!survey.feet.empty() || survey.arm.joints.empty()) return survey;
  }
  survey.base = UrdfOptions::Base::fixed;
  survey.srdf = srdf_beside(urdf);
  survey.locked = locked_joints(urdf, survey.base);
  if (!load_without_ends(survey, out)) return std::nullopt;
  const RobotData<double> data = data_in_state(*survey.plant.multibody(), survey.x);
  survey.arm = find_arm(survey.plant.robot(), data);
  return survey;
}

}  // namespace conddp
