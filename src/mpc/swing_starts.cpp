#include "mpc/swing_starts.hpp"

#include <stdexcept>
#include <utility>

namespace conddp {
namespace {

constexpr int kCoordinates = 3;

}  // namespace

SwingStarts::SwingStarts(FootSwings swings, const TimeLine& line)
    : swings_(std::move(swings)),
      references_(line.problem().knots() + 1),
      next_(swings_.feet, -1),
      places_(kCoordinates * swings_.feet),
      displacements_(places_.size()) {
  const std::vector<double>& times = line.problem().times();
  for (int i = 0; i < static_cast<int>(swings_.swings.size()); ++i) {
    const FootSwing& swing = swings_.swings[i];
    if (swing.nodes.empty() || swing.nodes.size() != swing.references.size() || swing.foot < 0 ||
        swing.foot >= swings_.feet || swing.nodes.front() < 0 ||
        swing.nodes.back() > line.problem().knots())
      throw std::invalid_argument("a swing is not one of the problem's");
    const double begin = times[swing.nodes.front()], end = times[swing.nodes.back()];
    for (std::size_t k = 0; k < swing.nodes.size(); ++k) {
      const double s = end > begin ? (times[swing.nodes[k]] - begin) / (end - begin) : 1;
      references_[swing.nodes[k]].push_back({i, swing.references[k], 1 - s * s * (3 - 2 * s)});
    }
  }
}

void SwingStarts::see(const TimeLine& line, double time, const double* x) {
  swings_.find_feet(x, places_.data());
  const std::vector<double>& times = line.problem().times();
  next_.assign(next_.size(), -1);
  for (int i = 0; i < static_cast<int>(swings_.swings.size()); ++i) {
    const FootSwing& swing = swings_.swings[i];
    const int known = next_[swing.foot];
    const bool is_earlier = known < 0 || swing.nodes.front() < swings_.swings[known].nodes.front();
    if (is_before(time, times[swing.nodes.back()]) && is_earlier) next_[swing.foot] = i;
  }
  for (int foot = 0; foot < swings_.feet; ++foot) {
    if (next_[foot] < 0) continue;
    const FootSwing& swing = swings_.swings[next_[foot]];
    const int first = swing.nodes.front();
    if (is_before(times[first], time)) continue;
    const double* foothold = line.numbers(first).parameters + swing.references.front();
    for (int c = 0; c < kCoordinates; ++c)
      displacements_[kCoordinates * foot + c] = places_[kCoordinates * foot + c] - foothold[c];
  }
}

void SwingStarts::displace(int node, double* parameters) const {
  for (const auto& [swing, parameter, share] : references_[node]) {
    const int foot = swings_.swings[swing].foot;
    if (next_[foot] != swing) continue;
    for (int c = 0; c < kCoordinates; ++c)
      parameters[parameter + c] += share * displacements_[kCoordinates * foot + c];
  }
}

}  // namespace conddp
