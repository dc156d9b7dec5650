#pragma once

#include <algorithm>
#include <utility>
#include <vector>

#include "problem_file/model/components.hpp"
#include "problem_file/plant/plant.hpp"

namespace conddp {

/// Values of joints from a mapping by joint names, in the order of the file. If several names fit,
/// an exact one wins over one with `*`, and a longer one over a shorter one. Names that fit no
/// joint are reported.
template <class T>
std::vector<std::pair<int, T>> values_of_joints(const RobotModel& robot,
                                                const std::vector<std::pair<Name, T>>& said,
                                                const std::string& prefix, Diagnostics& out) {
  std::vector<std::pair<int, T>> values;
  std::vector<std::size_t> qualities;
  for (const auto& [name, value] : said)
    for (const int joint : find_joints(robot, name, prefix, out)) {
      const std::size_t quality = fit(prefix + name.value, robot.joints[joint].name);
      const auto known = std::find_if(values.begin(), values.end(),
                                      [&](const auto& pair) { return pair.first == joint; });
      if (known == values.end()) {
        values.emplace_back(joint, value);
        qualities.push_back(quality);
      } else if (auto& best = qualities[known - values.begin()]; quality >= best) {
        known->second = value;
        best = quality;
      }
    }
  return values;
}

}  // namespace conddp
