#include "mpc/open_end.hpp"

#include <algorithm>
#include <stdexcept>
#include <utility>

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

OpenEnd::OpenEnd(Phase phase, std::shared_ptr<const StatePath> path)
    : phase_(std::move(phase)), tangent_(phase_.model->ndx()) {
  const int nx = phase_.model->nx();
  const auto add = [&](const auto& term) {
    if (term.residual->parameter_count() == nx) references_.push_back(term.parameters);
  };
  for (const CostTerm& cost : phase_.model->costs()) add(cost);
  for (const ConstraintTerm& constraint : phase_.model->constraints()) add(constraint);
  follow(std::move(path));
}

void OpenEnd::check(const StatePath& path) const {
  bool fits = !path.times.empty() && path.times.size() == path.states.size();
  for (const std::vector<double>& x : path.states)
    fits = fits && static_cast<int>(x.size()) == phase_.model->nx();
  if (!fits)
    throw std::invalid_argument("the path of the terminal node is not one of the problem's states");
}

void OpenEnd::follow(std::shared_ptr<const StatePath> path) {
  if (path == nullptr) return;
  check(*path);
  path_ = std::move(path);
}

void OpenEnd::move_to(double time) {
  if (path_ == nullptr) return;
  for (const int reference : references_)
    path_->state_at(phase_.model->manifold(), time, tangent_.data(),
                    phase_.parameters.data() + reference);
}

}  // namespace conddp
