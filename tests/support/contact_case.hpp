#pragma once

#include <memory>
#include <string>
#include <vector>

#include "support/mimic_robot.hpp"
#include "support/random_contact.hpp"
#include "support/random_robot.hpp"
#include "support/relative_frame.hpp"
#include "support/robots.hpp"
#include "systems/multibody/multibody.hpp"

namespace conddp {

/// A robot with contacts of mixed kinds on several of its bodies.
struct ContactCase {
  std::string name;
  std::shared_ptr<const RobotModel> robot;
  std::vector<Contact> contacts;
};

/// Every kind of contact in either axes on every robot, and sets of several contacts.
inline std::vector<ContactCase> contact_cases() {
  std::vector<TestModel> robots = random_robots();
  for (TestModel& robot : mimic_robots()) {
    robot.name = "mimic_" + robot.name;
    robots.push_back(std::move(robot));
  }
  for (const TestRobot& robot : five_robots())
    robots.push_back({"our_" + robot.name, *load(robot)});
  robots.push_back({"loaded_mimic", loaded_robot(mimic_robots().front().model, 23)});
  RandomNumbers random(17), of_loops(18);
  std::vector<ContactCase> cases;
  for (const TestModel& r : robots) {
    const auto robot = std::make_shared<RobotModel>(r.model);
    const std::vector<int> frames = moving_frames(*robot);
    const int n = static_cast<int>(frames.size());
    const auto contact = [&](int i, ContactKind kind, FrameAxes axes) {
      return random_contact(frames[i % n], kind, axes, random);
    };
    using K = ContactKind;
    using A = FrameAxes;
    cases.push_back({r.name + "_normal", robot, {contact(0, K::normal, A::world_aligned)}});
    cases.push_back({r.name + "_local_normal", robot, {contact(1, K::normal, A::local)}});
    cases.push_back({r.name + "_planar", robot, {contact(0, K::planar, A::world_aligned)}});
    cases.push_back({r.name + "_local_planar", robot, {contact(1, K::planar, A::local)}});
    cases.push_back({r.name + "_point", robot, {contact(0, K::point, A::world_aligned)}});
    const auto loop = [&](int i, ContactKind kind, FrameAxes axes) {
      Contact c = random_contact(frames[i % n], kind, axes, of_loops);
      const std::size_t enough = c.rows() + 2;
      c.base = frame_elsewhere(*robot, c.frame, of_loops.index(100), enough);
      return c;
    };
    cases.push_back({r.name + "_planar_loop", robot, {loop(0, K::planar, A::world_aligned)}});
    if (robot->nv < 8) continue;
    cases.push_back({r.name + "_surface", robot, {contact(0, K::surface, A::world_aligned)}});
    cases.push_back({r.name + "_loops",
                     robot,
                     {random_contact(frames[n / 3], K::normal, A::world_aligned, of_loops),
                      loop(0, K::point, A::local)}});
    cases.push_back({r.name + "_weld", robot, {loop(n / 2, K::surface, A::local)}});
    cases.push_back({r.name + "_mixed",
                     robot,
                     {contact(0, K::point, A::world_aligned), contact(n / 2, K::normal, A::local),
                      contact(n - 1, K::planar, A::world_aligned)}});
  }
  return cases;
}

}  // namespace conddp
