#include "analysis/certificate/node_derivatives.hpp"

#include <map>
#include <memory>

#include "ocp/knot/knot_batch.hpp"

namespace conddp {
namespace {

using D = Dual<Lane>;

/// A knot in dual numbers that move along one entry of z = (δx, δu) in each lane.
class MovingKnot {
 public:
  explicit MovingKnot(const KnotModel& model) : model_(model), batch_(model) {}

  /// The entries of z from `first` on.
  void evaluate(const KnotView& knot, const Trajectory& trajectory, int k, int first) {
    for (int i = 0; i < model_.nx(); ++i) batch_.x[i] = D(trajectory.x(k)[i]);
    for (int i = 0; i < model_.nu(); ++i) batch_.u[i] = D(trajectory.u(k)[i]);
    for (int i = 0; i < model_.parameter_count(); ++i) batch_.parameters[i] = D(knot.parameters[i]);
    batch_.dt = D(knot.dt);
    batch_.cost_scale = D(knot.cost_scale);
    std::fill(batch_.tangent.begin(), batch_.tangent.end(), D(0.0));
    const int ndx = model_.ndx();
    for (int l = 0; l < kLaneWidth && first + l < model_.nz(); ++l)
      (first + l < ndx ? batch_.tangent[first + l] : batch_.u[first + l - ndx]).d.set(l, 1);
    if (first < ndx)
      model_.manifold().integrate(batch_.x.data(), batch_.tangent.data(), batch_.x.data());
    model_.evaluate(batch_.input(), batch_.work);
  }

  /// Slopes of cost and constraints, into columns from `first` on.
  void write_values(int first, int count, NodeDerivatives& out) const {
    for (int l = 0; l < count; ++l) {
      out.cost[first + l] = batch_.work.cost.d[l];
      for (int i = 0; i < model_.constraint_rows(); ++i)
        out.constraint(i, first + l) = batch_.work.constraint[i].d[l];
    }
  }

  /// Slopes of f ⊕ (−gap) ⊖ x_next.
  void write_step(const Trajectory& trajectory, int k, const Eigen::MatrixXd& gap, int first,
                  int count, NodeDerivatives& out) {
    for (int i = 0; i < model_.ndx(); ++i) batch_.tangent[i] = D(-gap(i, k));
    model_.manifold().integrate(batch_.work.next().data(), batch_.tangent.data(), batch_.x.data());
    for (int i = 0; i < model_.nx(); ++i) batch_.x_next[i] = D(trajectory.x(k + 1)[i]);
    model_.manifold().difference(batch_.x_next.data(), batch_.x.data(), batch_.tangent.data());
    for (int l = 0; l < count; ++l)
      for (int i = 0; i < model_.ndx(); ++i) out.step(i, first + l) = batch_.tangent[i].d[l];
  }

 private:
  const KnotModel& model_;
  KnotBatch<D> batch_;
};

}  // namespace

std::vector<NodeDerivatives> node_derivatives(const ShootingProblem& problem,
                                              const Trajectory& trajectory,
                                              const Eigen::MatrixXd& gap) {
  const int N = problem.knots(), ndx = problem.ndx();
  std::vector<NodeDerivatives> all(N + 1);
  std::map<const KnotModel*, std::unique_ptr<MovingKnot>> memory;
  for (int k = 0; k <= N; ++k) {
    const KnotView& view = problem.knot(k);
    auto& knot = memory[view.model];
    if (!knot) knot = std::make_unique<MovingKnot>(*view.model);
    NodeDerivatives& out = all[k];
    const int nz = k < N ? view.model->nz() : ndx, rows = view.model->constraint_rows();
    out.cost.resize(nz);
    out.constraint.resize(rows, nz);
    if (k < N) out.step.resize(ndx, nz);
    for (int first = 0; first < nz; first += kLaneWidth) {
      const int count = std::min(kLaneWidth, nz - first);
      knot->evaluate(view, trajectory, k, first);
      knot->write_values(first, count, out);
      if (k < N) knot->write_step(trajectory, k, gap, first, count, out);
    }
  }
  return all;
}

}  // namespace conddp
