#include "analysis/derivatives/node_derivatives.hpp"

#include <algorithm>

#include "ocp/knot/knot_model.hpp"
#include "spatial/lane.hpp"

namespace conddp {

/// The lanes of one model. Lanes after the last move repeat it.
class MovingNodes::Batch {
 public:
  explicit Batch(const KnotModel& model) : model_(model), batch_(model) {}

  void evaluate(const MovingNodes& at, std::span<const NodeMove> moves) {
    for (int lane = 0; lane < kLaneWidth; ++lane)
      load(at, moves[std::min<std::size_t>(lane, moves.size() - 1)], lane);
    model_.manifold().integrate(batch_.x.data(), batch_.tangent.data(), batch_.x.data());
    model_.evaluate(batch_.input(), batch_.work);
    if (model_.integrator() == Integrator::none) return;
    for (int lane = 0; lane < kLaneWidth; ++lane)
      load_step(at, moves[std::min<std::size_t>(lane, moves.size() - 1)].node, lane);
    model_.manifold().integrate(batch_.work.next().data(), batch_.tangent.data(), batch_.x.data());
    model_.manifold().difference(batch_.x_next.data(), batch_.x.data(), batch_.tangent.data());
  }

  void write(int lane, const SlopePlaces& out) const {
    *out.cost = batch_.work.cost.d[lane];
    for (int i = 0; i < model_.constraint_rows(); ++i)
      out.constraint[i] = batch_.work.constraint[i].d[lane];
    if (out.step == nullptr) return;
    for (int i = 0; i < model_.ndx(); ++i) out.step[i] = batch_.tangent[i].d[lane];
  }

 private:
  /// Loads the numbers of a node, and the motion of its state and control.
  void load(const MovingNodes& at, const NodeMove& move, int lane) {
    const KnotView& view = at.problem_.knot(move.node);
    const auto set = [lane](Dual<Lane>& to, double value, double slope) {
      to.v.set(lane, value);
      to.d.set(lane, slope);
    };
    for (int i = 0; i < model_.nx(); ++i) set(batch_.x[i], at.trajectory_.x(move.node)[i], 0);
    for (int i = 0; i < model_.ndx(); ++i) set(batch_.tangent[i], 0, move.direction[i]);
    for (int i = 0; i < model_.nu(); ++i)
      set(batch_.u[i], at.trajectory_.u(move.node)[i], move.direction[model_.ndx() + i]);
    for (int i = 0; i < model_.parameter_count(); ++i)
      set(batch_.parameters[i], view.parameters[i], 0);
    set(batch_.dt, view.dt, 0);
    set(batch_.cost_scale, view.cost_scale, 0);
  }

  /// Loads the next state, and the step from f towards it.
  void load_step(const MovingNodes& at, int node, int lane) {
    const auto next = at.trajectory_.x(node + 1);
    for (int i = 0; i < model_.nx(); ++i) batch_.x_next[i].v.set(lane, next[i]);
    for (int i = 0; i < model_.ndx(); ++i) {
      batch_.tangent[i].v.set(lane, -at.gap_(i, node));
      batch_.tangent[i].d.set(lane, 0);
    }
  }

  const KnotModel& model_;
  KnotBatch<Dual<Lane>> batch_;
};

MovingNodes::MovingNodes(const ShootingProblem& problem, const Trajectory& trajectory,
                         const Eigen::MatrixXd& gap)
    : problem_(problem), trajectory_(trajectory), gap_(gap) {}
MovingNodes::~MovingNodes() = default;

void MovingNodes::evaluate(std::span<const NodeMove> moves) {
  const KnotModel& model = *problem_.knot(moves.front().node).model;
  auto& batch = batches_[&model];
  if (!batch) batch = std::make_unique<Batch>(model);
  current_ = batch.get();
  current_->evaluate(*this, moves);
}

void MovingNodes::write(int move, const SlopePlaces& out) const { current_->write(move, out); }

NodeDerivatives derivatives_of_node(const ShootingProblem& problem, int node, MovingNodes& moving) {
  const KnotModel& model = *problem.knot(node).model;
  const bool running = node < problem.knots();
  const int nz = model.nz();
  NodeDerivatives out{Eigen::VectorXd(nz), Eigen::MatrixXd(model.constraint_rows(), nz),
                      running ? Eigen::MatrixXd(model.ndx(), nz) : Eigen::MatrixXd()};
  const Eigen::MatrixXd directions = Eigen::MatrixXd::Identity(nz, nz);
  for (int first = 0; first < nz; first += kLaneWidth) {
    const int count = std::min(kLaneWidth, nz - first);
    NodeMove moves[kLaneWidth];
    for (int i = 0; i < count; ++i) moves[i] = {node, directions.col(first + i).data()};
    moving.evaluate({moves, static_cast<std::size_t>(count)});
    for (int i = 0; i < count; ++i)
      moving.write(i, {&out.cost[first + i], out.constraint.col(first + i).data(),
                       running ? out.step.col(first + i).data() : nullptr});
  }
  return out;
}

std::vector<NodeDerivatives> node_derivatives(const ShootingProblem& problem,
                                              const Trajectory& trajectory,
                                              const Eigen::MatrixXd& gap) {
  MovingNodes moving(problem, trajectory, gap);
  std::vector<NodeDerivatives> all;
  for (int k = 0; k <= problem.knots(); ++k) all.push_back(derivatives_of_node(problem, k, moving));
  return all;
}

}  // namespace conddp
