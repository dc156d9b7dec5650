#pragma once

#include <cmath>
#include <string>
#include <vector>

#include "robot/contact.hpp"
#include "support/random_numbers.hpp"

namespace conddp {

inline Vector3<double> random_unit(RandomNumbers& random) {
  const Vector3<double> v{random.uniform(-1, 1), random.uniform(-1, 1), random.uniform(0.2, 1)};
  return (1 / std::sqrt(squared_norm(v))) * v;
}

inline Contact random_contact(int frame, ContactKind kind, FrameAxes axes, RandomNumbers& random) {
  Contact c{.name = "c" + std::to_string(frame), .frame = frame, .kind = kind, .axes = axes};
  c.normal = random_unit(random);
  c.tangent = cross(c.normal, Vector3<double>{1, 0.3, 0});
  c.tangent = (1 / std::sqrt(squared_norm(c.tangent))) * c.tangent;
  c.kp = random.uniform(0, 10);
  c.kd = random.uniform(0, 10);
  c.reference = {rotation_matrix(random.rotation()),
                 {random.uniform(-1, 1), random.uniform(-1, 1), random.uniform(-1, 1)}};
  return c;
}

/// Movable frames of a model, last ones first: far from the root.
inline std::vector<int> moving_frames(const RobotModel& model) {
  std::vector<int> frames;
  for (int i = static_cast<int>(model.frames.size()) - 1; i >= 0; --i)
    if (model.frames[i].joint >= 0) frames.push_back(i);
  return frames;
}

}  // namespace conddp
