#include "ocp/evaluation/evaluator.hpp"

#include <algorithm>
#include <cmath>
#include <map>
#include <optional>
#include <utility>

#include <tbb/blocked_range.h>
#include <tbb/parallel_for.h>
#include <tbb/task_arena.h>

#include "ocp/evaluation/checkpoint.hpp"
#include "ocp/evaluation/evaluation_memory.hpp"
#include "ocp/evaluation/lane_transfer.hpp"
#include "ocp/evaluation/rollout.hpp"
#include "ocp/knot/knot_second_derivatives.hpp"

namespace conddp {

Feedback::Feedback(const ShootingProblem& problem) {
  for (int i = 0; i < problem.knots(); ++i) {
    k.push_back(Eigen::VectorXd::Zero(problem.nu(i)));
    K.push_back(Eigen::MatrixXd::Zero(problem.nu(i), problem.ndx()));
  }
}

void Feedback::set_zero() {
  for (Eigen::VectorXd& of_knot : k) of_knot.setZero();
  for (Eigen::MatrixXd& of_knot : K) of_knot.setZero();
}

Evaluation::Evaluation(const ShootingProblem& problem)
    : gap(Eigen::MatrixXd::Zero(problem.ndx(), problem.knots())),
      cost(Eigen::VectorXd::Zero(problem.knots() + 1)),
      augmentation(cost),
      constraint(Eigen::VectorXd::Zero(problem.constraint_rows())) {}

LaneRollout::LaneRollout(const ShootingProblem& problem)
    : cost(0.0), x((problem.knots() + 1) * problem.nx(), Lane(0.0)) {
  int controls = 0;
  for (int k = 0; k < problem.knots(); ++k) controls += problem.nu(k);
  u.assign(controls, Lane(0.0));
  std::fill(std::begin(first_bad_knot), std::end(first_bad_knot), -1);
}

void LaneRollout::extract(int lane, Trajectory& trajectory) const {
  const Lane* source = x.data();
  for (int k = 0; k <= trajectory.knots(); ++k)
    for (int i = 0; i < trajectory.nx(); ++i) trajectory.x(k)[i] = (*source++)[lane];
  source = u.data();
  for (int k = 0; k < trajectory.knots(); ++k)
    for (int i = 0; i < trajectory.nu(k); ++i) trajectory.u(k)[i] = (*source++)[lane];
}

namespace {

void pass_checkpoint_at(int knot) {
  if ((knot + 1) % kKnotsBetweenCheckpoints == 0) pass_checkpoint();
}

const std::shared_ptr<const KnotModel>& model_of(const ShootingProblem& problem, int k) {
  return k < problem.knots() ? problem.phases()[problem.knot(k).phase].model
                             : problem.terminal().model;
}

using OfModel = EvaluationMemory::OfModel;

/// Up to kLaneWidth knots of one model, one per lane.
struct Group {
  OfModel* of_model;
  int count;
  int knots[kLaneWidth];
};

}  // namespace

struct Evaluator::Impl {
  /// Workspace of simulate(): a rollout without feedback.
  struct Simulation {
    explicit Simulation(const ShootingProblem& problem) : none(problem), rollout(problem) {}
    Feedback none;
    SingleRollout rollout;
  };

  Impl(const ShootingProblem& p, std::shared_ptr<EvaluationMemory> shared)
      : problem(p), memory(std::move(shared)), threads(memory->threads()), arena(threads) {
    std::map<OfModel*, std::vector<int>> knots_of;
    for (int k = 0; k <= p.knots(); ++k) {
      OfModel& model = memory->of(model_of(p, k));
      std::vector<int>& knots = knots_of[&model];
      if (knots.empty()) models.push_back(&model);
      knots.push_back(k);
      by_knot.push_back(&model);
    }
    for (OfModel* model : models) add_groups(*model, knots_of[model]);
  }

  /// Calls act(group, thread) for every group, in parallel if there are several threads.
  template <class F>
  void for_each_group(F act) {
    for (std::size_t first = 0; first < groups.size(); first += kKnotsBetweenCheckpoints) {
      if (first > 0) pass_checkpoint();
      const std::size_t end = std::min(groups.size(), first + kKnotsBetweenCheckpoints);
      if (threads == 1) {
        for (std::size_t i = first; i < end; ++i) act(groups[i], 0);
        continue;
      }
      arena.execute([&] {
        tbb::parallel_for(first, end, [&](std::size_t i) {
          act(groups[i], tbb::this_task_arena::current_thread_index());
        });
      });
    }
  }

  /// Gathers a group's knots into a batch, one per lane.
  template <class S>
  void load(const Group& group, const Trajectory& t, const Augmentation* augmentation,
            KnotBatch<S>& batch) const {
    const KnotModel& model = *group.of_model->model;
    const bool running = model.integrator() != Integrator::none;
    const double* from[kLaneWidth];
    const auto gather = [&](int n, AlignedVector<S>& to, auto place) {
      for (int l = 0; l < group.count; ++l) from[l] = place(group.knots[l]);
      gather_lanes(from, group.count, n, [&to](int i, Lane value) { lane_of(to[i]) = value; });
    };
    gather(model.nx(), batch.x, [&](int k) { return t.x(k).data(); });
    gather(model.parameter_count(), batch.parameters,
           [&](int k) { return problem.knot(k).parameters; });
    if (running) {
      gather(model.nu(), batch.u, [&](int k) { return t.u(k).data(); });
      gather(model.nx(), batch.x_next, [&](int k) { return t.x(k + 1).data(); });
    }
    for (int l = 0; l < kLaneWidth; ++l) {
      const KnotView& view = problem.knot(group.knots[l]);
      lane_of(batch.dt).set(l, view.dt);
      lane_of(batch.cost_scale).set(l, view.cost_scale);
    }
    batch.augmented = augmentation != nullptr;
    if (!batch.augmented) return;
    const auto gather_rows = [&](const Eigen::VectorXd& rows, AlignedVector<S>& to) {
      gather(model.constraint_rows(), to,
             [&](int k) { return rows.data() + problem.constraint_offset(k); });
    };
    gather_rows(augmentation->penalty, batch.penalty);
    gather_rows(augmentation->shift, batch.shift);
    gather_rows(augmentation->multiplier, batch.multiplier);
  }

  /// Stores costs, gaps and constraint values in an Evaluation or a Linearization.
  template <class Out>
  void store_values(const Group& group, KnotBatch<Lane>& batch, Out& out) const {
    const KnotModel& model = *group.of_model->model;
    double *gap[kLaneWidth], *constraint[kLaneWidth];
    const bool running = model.integrator() != Integrator::none;
    for (int l = 0; l < group.count; ++l) {
      const int k = group.knots[l];
      out.cost[k] = batch.work.cost[l];
      out.augmentation[k] = batch.work.augmentation[l];
      constraint[l] = out.constraint.data() + problem.constraint_offset(k);
      if (running) gap[l] = out.gap.col(k).data();
    }
    scatter_lanes(batch.work.constraint.data(), model.constraint_rows(), constraint, group.count);
    if (!running) return;
    model.manifold().difference(batch.x_next.data(), batch.work.next().data(),
                                batch.tangent.data());
    scatter_lanes(batch.tangent.data(), model.ndx(), gap, group.count);
  }

  void store_derivatives(const Group& group, const KnotBatch<Lane>& batch,
                         Linearization& out) const {
    const KnotModel& model = *group.of_model->model;
    const KnotWorkspace<Lane>& work = batch.work;
    double* to[kLaneWidth];
    const auto place = [&](auto of_node) -> double* const* {
      for (int l = 0; l < group.count; ++l) to[l] = of_node(out.knots[group.knots[l]]);
      return to;
    };
    scatter_lanes(work.gradient.data(), model.nz(),
                  place([](KnotLinearization& knot) { return knot.gradient.data(); }), group.count);
    const HessianFill fill = work.rest_is_zero() ? HessianFill::lasting : HessianFill::pattern;
    const OfModel& places = *group.of_model;
    (fill == HessianFill::lasting ? places.lasting_hessian : places.hessian)(
        work.hessian.data(),
        place([fill](KnotLinearization& knot) { return knot.hessian.change(fill).data(); }),
        group.count);
    places.constraint(work.constraint_jacobian.data(),
                      place([](KnotLinearization& knot) { return knot.C.data(); }), group.count);
    scatter_lanes(work.F().data(), static_cast<int>(work.F().size()),
                  place([](KnotLinearization& knot) { return knot.F.data(); }), group.count);
    for (int l = 0; l < group.count; ++l)
      out.knots[group.knots[l]].dt = problem.knot(group.knots[l]).dt;
    const KnotLinearization& first = out.knots[group.knots[0]];
    const auto store_blocks = [&](const AlignedVector<Lane>& blocks, auto member) {
      for (std::size_t s = 0; s < (first.*member).size(); ++s) {
        const int n = first.curved[s].n;
        for (int i = 0; i < n; ++i)
          scatter_lanes(
              &blocks[s * StateManifold::kBlockSize + i * n], n,
              place([&](KnotLinearization& knot) { return (knot.*member)[s].row(i).data(); }),
              group.count);
      }
    };
    store_blocks(work.state_blocks(), &KnotLinearization::A);
    store_blocks(work.step_blocks(), &KnotLinearization::H);
  }

  void add_groups(OfModel& model, const std::vector<int>& knots) {
    for (std::size_t first = 0; first < knots.size(); first += kLaneWidth) {
      Group& group = groups.emplace_back();
      group.of_model = &model;
      group.count = static_cast<int>(std::min<std::size_t>(kLaneWidth, knots.size() - first));
      for (int l = 0; l < kLaneWidth; ++l)
        group.knots[l] = knots[first + std::min(l, group.count - 1)];
    }
  }

  /// Clears the dual parts of all inputs that are constant under differentiation.
  static void hold_constants(KnotBatch<Dual<Lane>>& batch) {
    for (auto* constants : {&batch.parameters, &batch.penalty, &batch.shift, &batch.multiplier})
      for (Dual<Lane>& a : *constants) a.d = Lane(0.0);
    batch.dt.d = batch.cost_scale.d = Lane(0.0);
  }

  /// A column of the Hessians, from the gradient's derivative along it; if `running`, that of λᵀf
  /// is added.
  static void store_column(const Group& group, int d, int nz, bool running,
                           const KnotBatch<Dual<Lane>>& batch, Linearization& out) {
    for (int l = 0; l < group.count; ++l) {
      auto column = out.knots[group.knots[l]].hessian.change().col(d);
      for (int c = 0; c < nz; ++c)
        column[c] = batch.work.gradient[c].d[l] + (running ? batch.pulled[c].d[l] : 0.0);
    }
  }

  /// Hessians of cost + λᵀf of a group's knots: derivatives of the gradients by dual numbers.
  void differentiate_gradients(const Group& group, const Trajectory& trajectory,
                               const Eigen::MatrixXd& costates, const Augmentation* augmentation,
                               KnotBatch<Dual<Lane>>& batch, Linearization& out) const {
    const KnotModel& model = *group.of_model->model;
    const int nz = model.nz();
    hold_constants(batch);
    const bool running = model.integrator() != Integrator::none;
    if (running) load_costates(group, costates, batch);
    for (int d = 0; d < nz; ++d) {
      load(group, trajectory, augmentation, batch);
      move_along(d, model, batch);
      model.differentiate(batch.input(), batch.work, false);
      if (running)
        transposed_dynamics(model, batch.work, batch.dt, batch.lambda.data(), batch.tangent.data(),
                            batch.pulled.data());
      store_column(group, d, nz, running, batch, out);
    }
    for (int l = 0; l < group.count; ++l)
      make_symmetric(out.knots[group.knots[l]].hessian.change());
  }

  static void load_costates(const Group& group, const Eigen::MatrixXd& costates,
                            KnotBatch<Dual<Lane>>& batch) {
    for (int i = 0; i < costates.rows(); ++i) {
      batch.lambda[i] = Dual<Lane>(0.0);
      for (int l = 0; l < kLaneWidth; ++l)
        batch.lambda[i].v.set(l, costates(i, group.knots[l] + 1));
    }
  }

  /// Seeds the inputs with the direction of column d of z.
  static void move_along(int d, const KnotModel& model, KnotBatch<Dual<Lane>>& batch) {
    const int n = model.ndx();
    for (int i = 0; i < model.nx(); ++i) batch.x[i].d = Lane(0.0);
    for (int i = 0; i < model.nu(); ++i) batch.u[i].d = Lane(0.0);
    if (d >= n) {
      batch.u[d - n].d = Lane(1.0);
      return;
    }
    for (int i = 0; i < n; ++i) batch.tangent[i] = Dual<Lane>(0.0);
    batch.tangent[d].d = Lane(1.0);
    model.manifold().integrate(batch.x.data(), batch.tangent.data(), batch.x.data());
  }

  /// The derivative of the gradient along the manifold differs from the Hessian only by an
  /// antisymmetric (Lie bracket) term.
  static void make_symmetric(Eigen::MatrixXd& h) {
    for (int c = 0; c < h.cols(); ++c)
      for (int r = 0; r < c; ++r) h(r, c) = h(c, r) = 0.5 * (h(r, c) + h(c, r));
  }

  const ShootingProblem& problem;
  std::shared_ptr<EvaluationMemory> memory;
  int threads;
  tbb::task_arena arena;
  std::vector<OfModel*> models;   ///< without duplicates
  std::vector<OfModel*> by_knot;  ///< N + 1
  std::vector<Group> groups;
  std::optional<Simulation> simulation;  ///< created on first use
};

Evaluator::Evaluator(const ShootingProblem& problem, int threads)
    : Evaluator(problem, std::make_shared<EvaluationMemory>(threads)) {}
Evaluator::Evaluator(const ShootingProblem& problem, std::shared_ptr<EvaluationMemory> memory)
    : problem_(problem), impl_(std::make_unique<Impl>(problem, std::move(memory))) {}
Evaluator::~Evaluator() = default;

void Evaluator::evaluate(const Trajectory& trajectory, Evaluation& out,
                         const Augmentation* augmentation) {
  impl_->for_each_group([&](const Group& group, int thread) {
    KnotBatch<Lane>& batch = *group.of_model->lanes[thread];
    impl_->load(group, trajectory, augmentation, batch);
    group.of_model->model->evaluate(batch.input(), batch.work);
    impl_->store_values(group, batch, out);
  });
}

void Evaluator::differentiate(const Trajectory& trajectory, Linearization& out,
                              const Augmentation* augmentation) {
  impl_->for_each_group([&](const Group& group, int thread) {
    KnotBatch<Lane>& batch = *group.of_model->lanes[thread];
    impl_->load(group, trajectory, augmentation, batch);
    group.of_model->model->differentiate(batch.input(), batch.work, true);
    impl_->store_values(group, batch, out);
    impl_->store_derivatives(group, batch, out);
  });
}

void Evaluator::reserve_lagrangian_hessian(bool by_parts) {
  for (OfModel* model : impl_->models) model->reserve_second_derivatives(by_parts);
}

void Evaluator::lagrangian_hessian(const Trajectory& trajectory, const Eigen::MatrixXd& costates,
                                   Linearization& out, const Augmentation* augmentation) {
  reserve_lagrangian_hessian();
  impl_->for_each_group([&](const Group& group, int thread) {
    KnotSecondDerivatives* parts = group.of_model->seconds[thread].get();
    if (parts == nullptr)
      return impl_->differentiate_gradients(group, trajectory, costates, augmentation,
                                            *group.of_model->duals[thread], out);
    const KnotModel& model = *group.of_model->model;
    KnotBatch<Lane>& batch = *group.of_model->lanes[thread];
    impl_->load(group, trajectory, augmentation, batch);
    if (model.integrator() != Integrator::none) {
      const double* from[kLaneWidth];
      for (int l = 0; l < group.count; ++l) from[l] = costates.col(group.knots[l] + 1).data();
      gather_lanes(from, group.count, model.ndx(),
                   [&batch](int i, Lane value) { batch.lambda[i] = value; });
    }
    const AlignedVector<Lane>& hessian = parts->compute(batch.lambda.data());
    double* to[kLaneWidth];
    for (int l = 0; l < group.count; ++l) to[l] = out.knots[group.knots[l]].hessian.change().data();
    scatter_lanes(hessian.data(), static_cast<int>(hessian.size()), to, group.count);
  });
}

void Evaluator::roll_out(const Trajectory& reference, const Eigen::MatrixXd& gap,
                         const Feedback& feedback, const double* step_lengths,
                         const RolloutOptions& options, LaneRollout& out) {
  Lane alpha;
  for (int l = 0; l < kLaneWidth; ++l) {
    alpha.set(l, step_lengths[l]);
    out.first_bad_knot[l] = -1;
  }
  const auto batch_of = [&](int k) -> KnotBatch<Lane>& {
    return *impl_->by_knot[k]->lanes.front();
  };
  conddp::roll_out(problem_, reference, gap, feedback, alpha, options, batch_of, out.x.data(),
                   out.u.data(), out.cost, [&](int k, Lane check) {
                     // A sum is finite only if its terms are finite; zero times a finite sum is
                     // zero.
                     pass_checkpoint_at(k);
                     bool alive = false;
                     for (int l = 0; l < kLaneWidth; ++l) {
                       if (out.first_bad_knot[l] < 0 && !(check[l] * 0.0 == 0.0))
                         out.first_bad_knot[l] = k;
                       alive = alive || out.first_bad_knot[l] < 0;
                     }
                     return alive;
                   });
}

void Evaluator::roll_out(const Trajectory& reference, const Eigen::MatrixXd& gap,
                         const Feedback& feedback, double step_length,
                         const RolloutOptions& options, SingleRollout& out) {
  out.first_bad_knot = -1;
  const auto batch_of = [&](int k) -> KnotBatch<double>& { return impl_->by_knot[k]->single; };
  conddp::roll_out(problem_, reference, gap, feedback, step_length, options, batch_of,
                   out.trajectory.x(0).data(),
                   problem_.knots() > 0 ? out.trajectory.u(0).data() : nullptr, out.cost,
                   [&](int k, double check) {
                     pass_checkpoint_at(k);
                     if (!std::isfinite(check)) out.first_bad_knot = k;
                     return out.first_bad_knot < 0;
                   });
}

int Evaluator::simulate(Trajectory& trajectory, bool clamp_controls) {
  if (!impl_->simulation) impl_->simulation.emplace(problem_);
  auto& [none, rollout] = *impl_->simulation;
  // With zero feedback, the reference states do not matter as long as they are finite.
  for (int k = 0; k <= trajectory.knots(); ++k)
    trajectory.x(k) =
        Eigen::Map<const Eigen::VectorXd>(problem_.initial_state().data(), problem_.nx());
  roll_out(trajectory, Eigen::MatrixXd(), none, 0.0, {.clamp_controls = clamp_controls}, rollout);
  if (rollout.first_bad_knot >= 0) return rollout.first_bad_knot;
  trajectory = rollout.trajectory;
  return -1;
}

}  // namespace conddp
