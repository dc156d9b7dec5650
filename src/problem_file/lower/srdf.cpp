#include "problem_file/lower/srdf.hpp"

#include <algorithm>
#include <set>
#include <sstream>
#include <string>

#include <fmt/format.h>
#include <pugixml.hpp>

#include "base/files/check_sums.hpp"
#include "base/files/text_file.hpp"
#include "base/text/spelling.hpp"

namespace conddp {
namespace {

/// The joints of a robot that have a coordinate of their own.
std::set<std::string> moving_joints(const RobotSpec& robot) {
  std::set<std::string> joints;
  pugi::xml_document urdf;
  const TextFile file = read_text_file(robot.path, kMaxDataBytes);
  urdf.load_buffer(file.text.data(), file.text.size());
  for (const pugi::xml_node& joint : urdf.child("robot").children("joint")) {
    const std::string name = joint.attribute("name").value();
    const std::string type = joint.attribute("type").value();
    const bool locked = std::ranges::any_of(
        robot.locked_joints, [&](const auto& entry) { return fits(entry.first.value, name); });
    const bool follows = robot.enforce_mimic && joint.child("mimic");
    if ((type == "revolute" || type == "continuous" || type == "prismatic") && !locked && !follows)
      joints.insert(name);
  }
  return joints;
}

std::vector<double> numbers_of(const pugi::xml_attribute& attribute) {
  std::vector<double> numbers;
  std::istringstream text(attribute.value());
  for (double number = 0; text >> number;) numbers.push_back(number);
  return numbers;
}

class Reader {
 public:
  Reader(RobotSpec& robot, CollisionSpec& collision, Diagnostics& out)
      : robot_(robot), place_(robot.srdf->place), collision_(collision), out_(out) {}

  void read() {
    const TextFile file = read_text_file(robot_.srdf_path, kMaxDataBytes);
    if (!file.defect.empty())
      return out_.error(place_, fmt::format("'{}': {}", robot_.srdf->value, file.defect));
    pugi::xml_document document;
    const pugi::xml_parse_result parsed = document.load_buffer(file.text.data(), file.text.size());
    if (!parsed || !document.child("robot"))
      return out_.error(place_, fmt::format("'{}' is no SRDF file: {}", robot_.srdf->value,
                                            parsed ? "it has no <robot>" : parsed.description()));
    out_.add_data_file({robot_.srdf_path.string(), sha256(file.text)});
    joints_ = moving_joints(robot_);
    const pugi::xml_node root = document.child("robot");
    for (const pugi::xml_node& state : root.children("group_state")) add_state(state);
    for (auto& [name, state] : states_) robot_.configurations.emplace_back(name, std::move(state));
    const std::string prefix = robot_.name.value.empty() ? "" : robot_.name.value + "/";
    for (const pugi::xml_node& pair : root.children("disable_collisions"))
      collision_.disabled.emplace_back(prefix + pair.attribute("link1").value(),
                                       prefix + pair.attribute("link2").value());
  }

 private:
  void add_state(const pugi::xml_node& group_state) {
    const std::string name = group_state.attribute("name").value();
    const auto has_name = [&](const auto& entry) { return entry.first.value == name; };
    if (name.empty() || std::ranges::any_of(robot_.configurations, has_name)) return;
    auto at = std::ranges::find_if(states_, has_name);
    if (at == states_.end())
      at = states_.insert(at, {Name{name, place_}, StateSpec{.place = place_}});
    for (const pugi::xml_node& joint : group_state.children("joint")) add_joint(joint, at->second);
  }

  void add_joint(const pugi::xml_node& joint, StateSpec& state) const {
    const std::string name = joint.attribute("name").value();
    const std::vector<double> values = numbers_of(joint.attribute("value"));
    if (joints_.contains(name) && values.size() == 1)
      state.joints.emplace_back(Name{name, place_}, values.front());
    if (joints_.contains(name) || values.size() != 7 || robot_.base != UrdfOptions::Base::floating)
      return;
    state.base =
        BaseSpec{.place = place_,
                 .position = {{values[0], values[1], values[2]}},
                 .orientation = Quaternion<double>{values[3], values[4], values[5], values[6]}};
  }

  RobotSpec& robot_;
  Place place_;
  CollisionSpec& collision_;
  Diagnostics& out_;
  std::set<std::string> joints_;
  std::vector<std::pair<Name, StateSpec>> states_;
};

}  // namespace

void read_srdf(ProblemSpec& spec, Diagnostics& out) {
  for (RobotSpec& robot : spec.robots) {
    if (!robot.srdf) continue;
    Reader(robot, spec.collision, out).read();
    robot.srdf.reset();
  }
}

}  // namespace conddp
