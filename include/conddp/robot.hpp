// Robots: URDF files and what conddp makes of them.
//
//   UrdfResult urdf = load_urdf("arm.urdf", {.base = UrdfOptions::Base::fixed});
//   for (const UrdfProblem& problem : urdf.problems) ...  // errors and warnings with their lines
//   if (!urdf.model) return;
//   const auto robot = std::make_shared<const RobotModel>(std::move(*urdf.model));
//   const int hand = robot->find_frame("hand").value();
//
// A RobotModel is immutable and may be shared between threads and systems. Its configuration is
// q = (p, quaternion x y z w) of a floating base, then the joints, depth first; its velocity
// v = (linear, angular) of the base in its own axes, then the joints' rates. Units are m, rad, kg,
// s, N and Nm. Every link and joint of the file has a frame of its name.
#pragma once

#include "robot/model.hpp"
#include "robot/urdf/urdf.hpp"
