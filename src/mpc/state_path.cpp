#include "mpc/state_path.hpp"

#include <algorithm>

namespace conddp {

void StatePath::state_at(const StateManifold& manifold, double time, double* tangent,
                         double* x) const {
  const auto after = std::upper_bound(times.begin(), times.end(), time);
  if (after == times.begin() || after == times.end()) {
    const std::vector<double>& end = after == times.begin() ? states.front() : states.back();
    std::copy(end.begin(), end.end(), x);
    return;
  }
  const auto next = after - times.begin();
  const double share = (time - times[next - 1]) / (times[next] - times[next - 1]);
  manifold.difference(states[next - 1].data(), states[next].data(), tangent);
  for (int i = 0; i < manifold.ndx(); ++i) tangent[i] *= share;
  manifold.integrate(states[next - 1].data(), tangent, x);
}

}  // namespace conddp
