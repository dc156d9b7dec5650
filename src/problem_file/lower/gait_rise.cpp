#include "problem_file/lower/gait_rise.hpp"

#include <algorithm>
#include <cmath>

#include "problem_file/motion/footholds.hpp"
#include "problem_file/motion/state_builder.hpp"
#include "problem_file/plant/plant_builder.hpp"

namespace conddp {

GaitRise::GaitRise(const std::vector<PathOfFoot>& feet, const ProblemSpec& spec) {
  Diagnostics own;
  const auto plant = build_plant(spec, own);
  const auto initial = plant ? StateBuilder(*plant, own).build(spec.initial_state) : std::nullopt;
  if (!initial) return;
  for (const PathOfFoot& path : feet) {
    const auto frame = find_frame(plant->robot(), path.frame, "", own);
    if (!frame) continue;
    const Vector3<double> start = placement_in_state(*plant->multibody(), *initial, *frame).p;
    Heights& heights = feet_.emplace_back(Heights{{0}, {0}});
    for (std::size_t i = 0; i < path.shares.size(); ++i) {
      const auto foothold = displaced_foothold({path.frame.value, *frame, start}, path.motions[i],
                                               spec, *plant, *initial);
      heights.shares.push_back(path.shares[i]);
      heights.rises.push_back(foothold ? foothold->p.z - start.z : heights.rises.back());
    }
  }
}

double GaitRise::at(double share) const {
  double sum = 0;
  for (const auto& [shares, rises] : feet_) {
    const auto next = std::ranges::upper_bound(shares, share);
    const std::size_t i = next - shares.begin();
    if (next == shares.end()) {
      sum += rises.back();
      continue;
    }
    const double part = (share - shares[i - 1]) / (shares[i] - shares[i - 1]);
    sum += rises[i - 1] + part * (rises[i] - rises[i - 1]);
  }
  return feet_.empty() ? 0 : sum / static_cast<double>(feet_.size());
}

std::vector<double> GaitRise::bends() const {
  std::vector<double> all;
  for (const Heights& foot : feet_)
    for (const double share : foot.shares) all.push_back(share);
  return all;
}

}  // namespace conddp
