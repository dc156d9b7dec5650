#include "analysis/lagrangian_gradient.hpp"

#include <cmath>
#include <map>
#include <memory>

#include "ocp/knot_batch.hpp"

namespace conddp {
namespace {

using D = Dual<Lane>;

/// A knot in dual numbers that move along one direction of z = (δx, δu) in each lane.
class MovingKnot {
 public:
  explicit MovingKnot(const KnotModel& model) : model_(model), batch_(model) {}

  /// The directions from `first` on: the columns given for the state, then the controls.
  void evaluate(const KnotView& knot, const Trajectory& trajectory, int k, int first,
                const Eigen::MatrixXd& directions) {
    for (int i = 0; i < model_.nx(); ++i) batch_.x[i] = D(trajectory.x(k)[i]);
    for (int i = 0; i < model_.nu(); ++i) batch_.u[i] = D(trajectory.u(k)[i]);
    for (int i = 0; i < model_.parameter_count(); ++i) batch_.parameters[i] = D(knot.parameters[i]);
    batch_.dt = D(knot.dt);
    batch_.cost_scale = D(knot.cost_scale);
    std::fill(batch_.tangent.begin(), batch_.tangent.end(), D(0.0));
    const int states = static_cast<int>(directions.cols());
    for (int l = 0; l < kLaneWidth && first + l < states + model_.nu(); ++l) {
      if (first + l >= states)
        batch_.u[first + l - states].d.set(l, 1);
      else
        for (int i = 0; i < model_.ndx(); ++i) batch_.tangent[i].d.set(l, directions(i, first + l));
    }
    if (first < states)
      model_.manifold().integrate(batch_.x.data(), batch_.tangent.data(), batch_.x.data());
    model_.evaluate(batch_.input(), batch_.work);
  }

  Lane cost_slope() const { return batch_.work.cost.d; }
  Lane constraint_slope(int row) const { return batch_.work.constraint[row].d; }

  /// Slopes of f ⊕ (−gap) ⊖ x_next, ndx entries.
  const AlignedVector<D>& closed_step(const Trajectory& trajectory, int k,
                                      const Eigen::MatrixXd& gap) {
    for (int i = 0; i < model_.ndx(); ++i) batch_.tangent[i] = D(-gap(i, k));
    model_.manifold().integrate(batch_.work.next().data(), batch_.tangent.data(), batch_.x.data());
    for (int i = 0; i < model_.nx(); ++i) batch_.x_next[i] = D(trajectory.x(k + 1)[i]);
    model_.manifold().difference(batch_.x_next.data(), batch_.x.data(), batch_.tangent.data());
    return batch_.tangent;
  }

 private:
  const KnotModel& model_;
  KnotBatch<D> batch_;
};

}  // namespace

LagrangianGradient lagrangian_gradient(const ShootingProblem& problem, const Trajectory& trajectory,
                                       const Eigen::MatrixXd& gap, const Eigen::MatrixXd& costates,
                                       const Eigen::VectorXd& multipliers,
                                       const Eigen::MatrixXd& directions) {
  const int N = problem.knots(), ndx = problem.ndx();
  const int states = static_cast<int>(directions.cols());
  LagrangianGradient out{-directions.transpose() * costates,
                         {},
                         directions.cwiseAbs().transpose() * costates.cwiseAbs(),
                         {}};
  std::map<const KnotModel*, std::unique_ptr<MovingKnot>> memory;
  for (int k = 0; k <= N; ++k) {
    const KnotView& view = problem.knot(k);
    auto& knot = memory[view.model];
    if (!knot) knot = std::make_unique<MovingKnot>(*view.model);
    if (k < N) {
      out.control.emplace_back(Eigen::VectorXd::Zero(problem.nu(k)));
      out.control_size.emplace_back(Eigen::VectorXd::Zero(problem.nu(k)));
    }
    const int count = states + view.model->nu();
    for (int first = 0; first < count; first += kLaneWidth) {
      knot->evaluate(view, trajectory, k, first, directions);
      Lane slope = knot->cost_slope(), size = abs(slope);
      const auto add = [&](const Lane& part) {
        slope += part;
        size += abs(part);
      };
      for (int i = 0; i < view.model->constraint_rows(); ++i)
        add(Lane(multipliers[problem.constraint_offset(k) + i]) * knot->constraint_slope(i));
      if (k < N) {
        const AlignedVector<D>& step = knot->closed_step(trajectory, k, gap);
        for (int i = 0; i < ndx; ++i) add(Lane(costates(i, k + 1)) * step[i].d);
      }
      for (int l = 0; l < kLaneWidth && first + l < count; ++l) {
        const int direction = first + l;
        const bool state = direction < states;
        (state ? out.state(direction, k) : out.control[k][direction - states]) += slope[l];
        (state ? out.state_size(direction, k) : out.control_size[k][direction - states]) += size[l];
      }
    }
  }
  return out;
}

}  // namespace conddp
