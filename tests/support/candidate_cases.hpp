#pragma once

#include <optional>
#include <string>
#include <vector>

#include "systems/contact/contact_candidate.hpp"

namespace conddp {

/// A sphere on a robot and its candidate; in a plane, if given.
struct CandidateCase {
  std::string name;
  ContactCandidate candidate;
  std::optional<Vector3<double>> plane;
};

/// A sphere on the body of the last joint with every kind of candidate, on the world and on a body
/// of another branch or near the root.
inline std::vector<CandidateCase> candidate_cases(const RobotModel& model) {
  int tip = 0, other = 0;
  for (int i = 0; i < static_cast<int>(model.frames.size()); ++i) {
    if (model.frames[i].joint == model.joint_count() - 1) tip = i;
    if (model.frames[i].joint == model.joint_count() / 2) other = i;
  }
  const ContactSphere sphere{tip, {0.1, -0.2, 0.3}, 0.05};
  const Vector3<double> normal{0.6, 0, 0.8};
  std::vector<CandidateCase> all;
  const auto add = [&](const std::string& name, auto against, bool planar = false) {
    ContactCandidate c{name, sphere, against, 0.5, {}};
    all.push_back(
        {name, c,
         planar ? std::optional<Vector3<double>>(Vector3<double>{0, 1, 0}) : std::nullopt});
  };
  add("ground", ContactHalfSpace{-1, {0, 0, 1}, -0.3});
  add("ceiling", ContactHalfSpace{-1, {0.48, 0.36, -0.8}, -2});
  add("slope in a plane", ContactHalfSpace{-1, normal, 0.1}, true);
  add("moving half-space", ContactHalfSpace{other, normal, 0.1});
  add("sphere of the world", ContactSphere{-1, {5, 4, 3}, 0.2});
  add("sphere of the robot", ContactSphere{other, {3, 0.1, 2}, 0.2});
  add("box of the world",
      ContactBox{-1, {Matrix3<double>::identity(), {8, 1, 0}}, {0.1, 0.2, 0.3}});
  add("box of the robot", ContactBox{other, {Matrix3<double>::identity(), {0, 9, 1}}, {1, 1, 1}});
  // Large enough to contain the sphere, nearest to each pair of faces in turn.
  add("inside of a box", ContactBox{other, SE3<double>::identity(), {40, 50, 60}});
  add("inside, below", ContactBox{-1, SE3<double>::identity(), {50, 40, 60}});
  add("inside, beside", ContactBox{-1, SE3<double>::identity(), {60, 50, 40}});
  return all;
}

}  // namespace conddp
