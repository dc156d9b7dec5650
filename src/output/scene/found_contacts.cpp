#include "output/scene/found_contacts.hpp"

#include "analysis/contact/contact_motion.hpp"
#include "output/scene/scene_numbers.hpp"

namespace conddp {
namespace {

/// The joint that carries a frame, −1 for the world.
int joint_of(const RobotModel& robot, int frame) {
  return frame < 0 ? -1 : robot.frames[frame].joint;
}

/// True if the counterpart of a candidate has flat faces and does not move, so that a robot can
/// stand on it.
bool is_ground(const RobotModel& robot, const ContactCandidate& candidate) {
  if (const auto* plane = std::get_if<ContactHalfSpace>(&candidate.against))
    return joint_of(robot, plane->frame) < 0;
  if (const auto* box = std::get_if<ContactBox>(&candidate.against))
    return joint_of(robot, box->frame) < 0;
  return false;
}

OrderedJson candidate_json(const RobotModel& robot, const ContactCandidate& candidate) {
  const ContactSphere& sphere = candidate.sphere;
  const int joint = joint_of(robot, sphere.frame);
  SE3<double> placement{Matrix3<double>::identity(), sphere.center};
  if (sphere.frame >= 0) placement = robot.frames[sphere.frame].placement * placement;
  return {{"name", candidate.name},
          {"body", joint + 1},
          {"placement", placement_json(placement)},
          {"friction", candidate.friction},
          {"half_size", nullptr},
          // The normals of a world-fixed sphere point into it.
          {"radius", joint < 0 ? -sphere.radius : sphere.radius},
          {"acts_after", 1},
          {"ground", joint >= 0 && is_ground(robot, candidate)},
          {"positions", OrderedJson::array()},
          {"normals", OrderedJson::array()}};
}

}  // namespace

namespace {

/// The sum of a force's components along the first few directions of a contact.
OrderedJson force_json(const Eigen::Vector3d& force, const ContactInstant<double>& at, int count) {
  Vector3<double> sum = Vector3<double>::zero();
  for (int i = 0; i < count; ++i) sum = sum + force[i] * at.directions[i];
  OrderedJson json = OrderedJson::array();
  for (const double x : {sum.x, sum.y, sum.z}) json.push_back(eight_digits(x));
  return json;
}

}  // namespace

FoundContacts found_contacts(const ContactMotion& motion) {
  const RobotModel& robot = *motion.plant.robot;
  const std::vector<ContactCandidate>& candidates = motion.plant.contacts.candidates;
  const double least = ContactSequenceOptions{}.share * impulse_scale(motion.plant, 1);
  FoundContacts found;
  for (const ContactCandidate& candidate : candidates) {
    found.contacts.push_back(candidate_json(robot, candidate));
    found.forces[candidate.name] = OrderedJson(motion.first_knot, nullptr);
  }
  ContactMechanics<double> mechanics(motion.plant);
  for (int k = 0; k <= motion.steps(); ++k) {
    const auto& instants = mechanics.look(motion.q[k].data());
    for (std::size_t c = 0; c < candidates.size(); ++c) {
      const double side = joint_of(robot, candidates[c].sphere.frame) < 0 ? -1 : 1;
      const ContactInstant<double>& at = instants[c];
      // The knot that chooses the initial state shows it too.
      for (int times = k == 0 ? 1 + motion.first_knot : 1; times > 0; --times) {
        append(found.contacts[c]["positions"], at.point);
        append(found.contacts[c]["normals"], side * at.directions[0]);
      }
      if (k == 0) continue;
      const Eigen::Vector3d force =
          side * motion.forces[k - 1].contact.col(c);  // at the end of the step
      const int count = 1 + tangent_count(motion.plant.contacts, candidates[c]);
      found.forces[candidates[c].name].push_back(
          side * force[0] > least ? force_json(force, at, count) : OrderedJson(nullptr));
    }
  }
  return found;
}

}  // namespace conddp
