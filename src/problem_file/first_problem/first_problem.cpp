#include "problem_file/first_problem/first_problem.hpp"

#include <algorithm>
#include <cmath>

#include <fmt/format.h>
#include <fmt/ranges.h>

#include "base/text/spelling.hpp"
#include "problem_file/assemble/build_problem.hpp"
#include "problem_file/first_problem/standing_pose.hpp"

namespace conddp {
namespace {

using MotionKind = FirstMotion::Kind;

/// Lines of YAML with comments in a column.
class CommentedLines {
 public:
  void add(const std::string& line, const std::string& comment = "") {
    constexpr std::size_t kColumn = 60;
    text += comment.empty() ? line : fmt::format("{:<{}}  # {}", line, kColumn, comment);
    text += '\n';
  }
  /// A flow mapping over as many lines as it needs.
  void add_mapping(const std::string& indent, const std::vector<std::string>& entries) {
    constexpr std::size_t kWidth = 100;
    std::string line = indent + "{";
    for (std::size_t i = 0; i < entries.size(); ++i) {
      const std::string entry = entries[i] + (i + 1 < entries.size() ? "," : "}");
      if (line.size() + entry.size() > kWidth) {
        add(line);
        line = indent;
      }
      line += (line.ends_with('{') ? "" : " ") + entry;
    }
    add(line);
  }

  std::string text;
};

/// A number with two digits, as YAML 1.1 and 1.2 read it.
std::string short_number(double number) {
  std::string text = fmt::format("{:.2g}", number);
  const std::size_t exponent = text.find('e');
  if (exponent != std::string::npos && text.find('.') == std::string::npos)
    text.insert(exponent, ".0");
  return text;
}

std::string vector_text(const Vector3<double>& p) {
  return fmt::format("[{}, {}, {}]", rounded(p.x), rounded(p.y), rounded(p.z));
}

/// Writes the problem of one robot.
class FirstProblemWriter {
 public:
  FirstProblemWriter(RobotSurvey survey, FirstMotion motion, std::filesystem::path folder)
      : survey_(std::move(survey)),
        motion_(std::move(motion)),
        folder_(std::move(folder)),
        robot_(survey_.plant.robot()),
        floating_(survey_.base == UrdfOptions::Base::floating) {}

  /// Completes the motion. Reports a motion that the robot cannot perform.
  bool prepare(Diagnostics& out) {
    choose_motion();
    if (!survey_.feet.empty()) {
      stand_up(survey_);
      name_feet();
    }
    const bool on_feet = motion_.kind == MotionKind::stand || motion_.kind == MotionKind::gait;
    if (on_feet && survey_.feet.empty()) {
      out.error({},
                fmt::format("'{}' has no feet to stand on: the tips of two chains of joints at "
                            "least, below its root link",
                            robot_.name),
                "give --reach FRAME for an arm");
      return false;
    }
    if (motion_.kind == MotionKind::gait && !check_gait(out)) return false;
    if (motion_.kind == MotionKind::reach && !find_goal(out)) return false;
    if (motion_.kind == MotionKind::by_kind && survey_.rotors.size() < 3) {
      out.error({}, fmt::format("'{}' has no joints, and no links named after rotors", robot_.name),
                "write a problem with thrusters: 'robot: {base: floating, frames: {rotor_1: "
                "{parent: body, placement: {position: [0.2, 0.2, 0]}}}, actuation: {thrusters: "
                "[{name: t_1, frame: rotor_1, torque_ratio: 0.02, upper: 10}]}}'");
      return false;
    }
    measure();
    return true;
  }

  /// The text. `limits`: whether it bounds torques by the limits of the URDF.
  std::string text(bool limits) const {
    CommentedLines lines;
    write_head(lines);
    write_robot(lines);
    write_contacts(lines);
    lines.add("initial_state: {configuration: start}", "at rest");
    write_time(lines);
    write_costs(lines);
    write_constraints(lines, limits);
    write_terminal(lines);
    lines.add("initial_guess: {states: initial, controls: quasi_static}",
              "torques that hold the robot at rest");
    return lines.text;
  }

 private:
  void choose_motion() {
    if (motion_.kind != MotionKind::by_kind) return;
    if (!survey_.feet.empty())
      motion_.kind = MotionKind::stand;
    else if (!floating_ && !survey_.arm.joints.empty())
      motion_.kind = MotionKind::reach;
  }
  bool flies() const { return motion_.kind == MotionKind::by_kind; }
  bool walks() const { return motion_.kind == MotionKind::gait; }
  bool soles() const { return std::ranges::all_of(survey_.feet, is_sole); }

  /// Sizes and wrench cones of soles are in the axes of their frames.
  bool has_wrench_cones() const {
    return soles() && std::ranges::all_of(placements_of_feet(survey_), is_upright);
  }

  /// Four feet are named as gaits call them: front and hind by x, left and right by y.
  void name_feet() {
    const std::vector<SE3<double>> places = placements_of_feet(survey_);
    Vector3<double> middle = Vector3<double>::zero();
    for (const SE3<double>& place : places)
      middle += (1.0 / static_cast<double>(places.size())) * place.p;
    for (const SE3<double>& place : places) {
      const Vector3<double> p = place.p - middle;
      const std::string side = p.y > 0 ? "L" : "R";
      names_.push_back(places.size() == 2 ? side : side + (p.x > 0 ? "F" : "H"));
    }
    std::vector<std::string> sorted = names_;
    std::ranges::sort(sorted);
    named_ = places.size() <= 4 && std::ranges::adjacent_find(sorted) == sorted.end();
    for (std::size_t i = 0; !named_ && i < names_.size(); ++i)
      names_[i] = robot_.frames[survey_.feet[i].tip].name;
  }

  bool check_gait(Diagnostics& out) const {
    std::vector<std::string> accepted{"jump"};
    if (named_ && names_.size() == 2) accepted = {"walk", "jump"};
    if (named_ && names_.size() == 4) accepted = {"walk", "trot", "pace", "bound", "jump"};
    if (std::ranges::find(accepted, motion_.gait) != accepted.end()) return true;
    out.error({},
              fmt::format("'{}' has {}, which cannot {}", robot_.name,
                          counted(names_.size(), named_ ? "foot" : "unordered foot"), motion_.gait),
              fmt::format("its gaits are: {}", fmt::join(accepted, ", ")), accepted);
    return false;
  }

  /// Where the frame is if the joints before it are turned by a fifth of their range, 0.3 rad (or
  /// m) at most, away from the nearer limit. So the goal can be reached.
  bool find_goal(Diagnostics& out) {
    const MultibodySystem& system = *survey_.plant.multibody();
    if (motion_.frame.empty() && !survey_.arm.joints.empty())
      motion_.frame = robot_.frames[survey_.arm.tip].name;
    const auto frame = find_frame(robot_, Name{motion_.frame, {}}, "", out);
    if (!frame) return false;
    std::vector<double> goal = survey_.x;
    int moved = 0;
    for (int joint = robot_.frames[*frame].joint; joint >= 0; joint = robot_.joints[joint].parent) {
      if (robot_.joints[joint].type == JointType::floating || !system.position_index(joint))
        continue;
      const auto limits = given_limits(system, joint);
      double& q = goal[*system.position_index(joint)];
      const double by = std::min(0.3, 0.2 * (limits.upper - limits.lower));
      q += limits.upper - q >= q - limits.lower ? by : -by;
      ++moved;
    }
    if (moved == 0) {
      out.error({}, fmt::format("no joint moves the frame '{}'", motion_.frame),
                name_hint("", frame_names(robot_), "frames"));
      return false;
    }
    goal_ = placement_in_state(system, goal, *frame).p;
    return true;
  }

  /// Measures the sizes that scale weights and durations.
  void measure() {
    const MultibodySystem& system = *survey_.plant.multibody();
    const double gravity = std::sqrt(squared_norm(robot_.gravity));
    weight_ = gravity * robot_.total_mass();
    const RobotData<double> data = data_in_state(system, survey_.x);
    for (const Limb& foot : survey_.feet) {
      const int hip = foot.joints.front();
      height_ += (data.root_pose(robot_, hip) * data.placement[hip]).p.z /
                 static_cast<double>(survey_.feet.size());
    }
    // The length of the arm: from joint to joint.
    Vector3<double> before = Vector3<double>::zero();
    const std::vector<int>& arm = survey_.arm.joints;
    for (std::size_t i = 0; i < arm.size(); ++i) {
      const Vector3<double> p = (data.root_pose(robot_, arm[i]) * data.placement[arm[i]]).p;
      if (i > 0) length_ += std::sqrt(squared_norm(p - before));
      before = p;
    }
    if (!arm.empty()) length_ += std::sqrt(squared_norm(frame_position(survey_.arm.tip) - before));
    std::vector<double> limits;
    for (const double upper : system.actuation().upper)
      if (upper > 0 && std::isfinite(upper)) limits.push_back(upper);
    std::ranges::sort(limits);
    // Larger limits than the torque that carries the robot on one stretched limb say nothing.
    torque_ = weight_ * std::max({height_, length_, 0.1});
    if (!limits.empty()) torque_ = std::min(torque_, limits[limits.size() / 2]);
    // Legs swing as pendulums do, within about half of their period.
    if (walks()) step_ = rounded(std::sqrt(std::max(height_, 0.05) / gravity) / 12);
  }
  Vector3<double> frame_position(int frame) const {
    return placement_in_state(*survey_.plant.multibody(), survey_.x, frame).p;
  }

  std::string motion_text() const {
    if (walks()) return motion_.gait;
    if (flies()) return "hover";
    return motion_.kind == MotionKind::stand ? "stand" : "reach";
  }

  void write_head(CommentedLines& lines) const {
    lines.add(fmt::format(
        "# A first problem for {}, guessed by 'conddp init'. All keys: docs/keys.md", robot_.name));
    lines.add("conddp: 1", "version of this format");
    lines.add(
        fmt::format("name: {}", yaml_name(survey_.urdf.stem().string() + "_" + motion_text())));
  }

  std::string urdf_name() const {
    std::error_code failed;
    const std::filesystem::path relative = std::filesystem::relative(survey_.urdf, folder_, failed);
    return yaml_name(failed || relative.empty() ? survey_.urdf.string() : relative.string());
  }

  void write_robot(CommentedLines& lines) const {
    lines.add("robot:");
    lines.add("  urdf: " + urdf_name(), "relative to this file");
    if (floating_) lines.add("  base: floating", "nothing holds the root link");
    if (!survey_.locked.empty()) {
      std::vector<std::string> locked;
      for (const auto& [name, value] : survey_.locked)
        locked.push_back(fmt::format("{}: {}", yaml_name(name.value), rounded(value)));
      lines.add("  locked_joints:", "fingers, wheels, rotors, joints without inertia");
      lines.add_mapping("    ", locked);
    }
    if (flies()) write_thrusters(lines);
    lines.add("  configurations:");
    lines.add("    start:", survey_.posture.empty()
                                ? "joints within their limits, rad and m"
                                : fmt::format("'{}' of {}, rad and m", survey_.posture,
                                              survey_.srdf.filename().string()));
    const MultibodySystem& system = *survey_.plant.multibody();
    if (floating_) {
      const std::vector<double>& x = survey_.x;
      std::string base = fmt::format("position: [0, 0, {}]", x[2]);
      if (std::abs(x[6]) < 1 - 1e-9)
        base += fmt::format(", orientation: [{}, {}, {}, {}]", x[3], x[4], x[5], x[6]);
      lines.add("      base: {" + base + "}", flies() ? "m" : "m; the feet are at height 0");
    }
    std::vector<std::string> joints;
    for (const int joint : movable_joints(system, 0, robot_.joint_count()))
      if (const double q = rounded(survey_.x[*system.position_index(joint)]); q != 0)
        joints.push_back(fmt::format("{}: {}", yaml_name(robot_.joints[joint].name), q));
    if (joints.empty()) {
      if (!floating_) lines.add("      joints: {}", "all at 0");
      return;
    }
    lines.add("      joints:", "others are at 0");
    lines.add_mapping("        ", joints);
  }

  /// Thrusters at the rotors, whose torques alternate around the body.
  void write_thrusters(CommentedLines& lines) const {
    std::vector<std::pair<double, int>> around;
    for (const int frame : survey_.rotors) {
      const Vector3<double> p = frame_position(frame);
      around.emplace_back(std::atan2(p.y, p.x), frame);
    }
    std::ranges::sort(around);
    lines.add("  actuation:");
    lines.add("    thrusters:", "guessed: N, and Nm of torque for each N");
    double sign = 1;
    for (const auto& [angle, frame] : around) {
      const std::string name = robot_.frames[frame].name;
      lines.add(fmt::format("      - {{name: {0}, frame: {0}, torque_ratio: {1}, upper: {2}}}",
                            yaml_name(name), 0.02 * sign,
                            short_number(2 * weight_ / static_cast<double>(around.size()))));
      sign = -sign;
    }
  }

  void write_contacts(CommentedLines& lines) const {
    if (survey_.feet.empty()) return;
    lines.add("contacts:", "the lowest tips of the robot's limbs");
    std::string kind = "type: point";
    if (soles()) kind = "type: surface";
    if (has_wrench_cones())
      kind = fmt::format("type: surface, size: [{}, {}]", short_number(0.2 * height_),
                         short_number(0.1 * height_));
    lines.add(fmt::format("  defaults: {{{},", kind),
              soles() ? "a guess of the soles' size, m" : "");
    lines.add(fmt::format("             friction: 0.7, baumgarte: {{kd: {}}}}}",
                          short_number(0.9 / step_)),
              "a foot stops within a time step");
    for (std::size_t i = 0; i < names_.size(); ++i)
      lines.add(fmt::format("  {}: {{frame: {}}}", yaml_name(names_[i]),
                            yaml_name(robot_.frames[survey_.feet[i].tip].name)));
  }

  void write_time(CommentedLines& lines) const {
    if (!walks()) {
      lines.add("phases:");
      lines.add(fmt::format("  - {{name: {}, knots: 50, dt: {}{}}}", motion_text(), step_,
                            survey_.feet.empty() ? "" : ", contacts: all"),
                "1 s");
      return;
    }
    const bool biped = names_.size() == 2;
    const int steps = motion_.gait != "walk" ? 24 : biped ? 48 : 96;
    lines.add("gait:");
    lines.add(fmt::format("  type: {}", motion_.gait), "which feet swing together");
    lines.add("  cycles: 2", "steps of each foot");
    lines.add(fmt::format("  period: {}", rounded(steps * step_)),
              "s; in proportion to the root of the legs' length");
    lines.add(fmt::format("  dt: {}", step_), "s");
    lines.add(fmt::format("  step: {{length: {}, height: {}}}", short_number(height_ / 4),
                          short_number(height_ / 10)),
              "m; a quarter and a tenth of the legs' length");
    lines.add(fmt::format("  stand: {{begin: {0}, end: {0}}}", rounded(10 * step_)),
              "s, on all feet");
  }

  std::string reference() const {
    return walks() ? "{configuration: start, displaced: gait}" : "start";
  }
  std::string state_weights() const {
    if (!floating_) return "{\"v/*\": 0.1}";
    const bool joints = robot_.joint_count() > 1;
    return fmt::format("{{\"base/r*\": 10, \"base/v*\": 0.1, \"base/w*\": 0.1{}}}",
                       joints ? ", \"v/*\": 0.01" : "");
  }

  void write_costs(CommentedLines& lines) const {
    lines.add("costs:");
    lines.add(fmt::format("  posture: {{residual: state, weight: {},",
                          motion_.kind == MotionKind::reach ? "0.1" : "10"),
              walks() ? "rad, m, rad/s, m/s; moves as the gait does" : "rad, m, rad/s, m/s; stays");
    lines.add(fmt::format("            reference: {},", reference()));
    lines.add(fmt::format("            weights: {}}}", state_weights()));
    if (flies()) {
      lines.add(fmt::format("  effort: {{residual: control, weight: {}}}",
                            short_number(1 / (weight_ * weight_))),
                "1/weight²");
      return;
    }
    lines.add(fmt::format("  effort: {{residual: {}, weight: {}}}",
                          survey_.feet.empty() ? "control_gravity" : "control",
                          short_number(1 / (torque_ * torque_))),
              "1/torque² of a middling joint");
    if (survey_.feet.empty()) return;
    // A violation by a hundredth of the weight costs fifty times as much as full torque.
    lines.add(fmt::format("  cone: {{residual: {}, contacts: all, weight: {}}}",
                          has_wrench_cones() ? "wrench_cone" : "friction_cone",
                          short_number(1e6 / (weight_ * weight_))),
              "feet push and do not slip; 10⁶/weight²");
  }

  void write_constraints(CommentedLines& lines, bool limits) const {
    if (!limits) {
      lines.add("# no torque limits: those of the URDF are 0, or do not hold the robot at rest");
      return;
    }
    lines.add("constraints:");
    lines.add("  torque: {bounds: control, from: urdf}",
              flies() ? "thrusts between 0 and 'upper'" : "limits of the URDF");
  }

  void write_terminal(CommentedLines& lines) const {
    lines.add("terminal:");
    lines.add("  costs:");
    if (motion_.kind == MotionKind::reach) {
      // A miss by a hundredth of the arm's length costs fifty times as much as full torque.
      const double length = std::max(length_, 0.1);
      lines.add(fmt::format("    goal: {{residual: frame_position, frame: {},",
                            yaml_name(motion_.frame)));
      lines.add(fmt::format("           reference: {}, weight: {}}}", vector_text(goal_),
                            short_number(1e6 / (length * length))),
                "m, in the world; 10⁶/length²");
      lines.add("    rest: {residual: joint_velocity, weight: 10}", "ends at rest");
      if (survey_.feet.empty()) return;
    }
    lines.add(fmt::format("    posture: {{residual: state, weight: {},",
                          motion_.kind == MotionKind::reach ? "1" : "100"),
              "ends in this posture, at rest");
    lines.add(fmt::format("              reference: {}}}", reference()));
  }

  RobotSurvey survey_;
  FirstMotion motion_;
  std::filesystem::path folder_;
  const RobotModel& robot_;
  bool floating_;
  std::vector<std::string> names_;                  ///< of the feet
  bool named_ = false;                              ///< with the names of gaits
  Vector3<double> goal_ = Vector3<double>::zero();  ///< m
  double weight_ = 0;                               ///< N
  double height_ = 0;                               ///< of the hips, m
  double length_ = 0;                               ///< of the arm, m
  double torque_ = 0;                               ///< Nm
  double step_ = 0.02;                              ///< s
};

/// True if all controls may move, and the guess, which holds the robot at rest, is within their
/// limits.
bool holds_within_limits(const std::string& text, const std::filesystem::path& folder,
                         Diagnostics& out) {
  const auto built =
      build_problem(read_problem_text(text, folder / "first.yaml", {}, out), {}, out);
  if (!built) return false;
  const Actuation& actuation = built->plant.multibody()->actuation();
  const auto u = built->guess.u(0);
  for (int i = 0; i < actuation.nu; ++i)
    if (actuation.lower[i] == actuation.upper[i] || u[i] < actuation.lower[i] ||
        u[i] > actuation.upper[i])
      return false;
  return true;
}

}  // namespace

std::optional<std::string> first_problem(const std::filesystem::path& urdf,
                                         const FirstMotion& motion,
                                         const std::filesystem::path& folder, Diagnostics& out) {
  auto survey = survey_robot(urdf, out);
  if (!survey) return std::nullopt;
  FirstProblemWriter writer(std::move(*survey), motion, folder);
  if (!writer.prepare(out)) return std::nullopt;
  const bool limits = holds_within_limits(writer.text(false), folder, out);
  if (out.has_errors()) return std::nullopt;
  return writer.text(limits);
}

}  // namespace conddp
