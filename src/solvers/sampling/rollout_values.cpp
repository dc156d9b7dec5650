#include "solvers/sampling/rollout_values.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

#include <tbb/parallel_for.h>
#include <tbb/task_arena.h>

#include "ocp/evaluation/checkpoint.hpp"
#include "ocp/evaluation/evaluation_memory.hpp"
#include "ocp/evaluation/evaluator.hpp"
#include "ocp/evaluation/rollout.hpp"

namespace conddp {
namespace {

constexpr RolloutValue kNoValue{std::numeric_limits<double>::quiet_NaN(),
                                std::numeric_limits<double>::quiet_NaN()};

/// Value of a rollout from the sum of its nodes' costs and the values of all constraint rows.
RolloutValue value_of(const ShootingProblem& problem, double cost, const Eigen::VectorXd& rows) {
  double squares = 0;
  for (const NodeConstraint& c : problem.constraints())
    if (!c.is_soft()) squares += soft_distance(*c.term, rows.data() + c.row, c.lower, c.upper, 2);
  const RolloutValue value{cost + linear_soft_cost(problem, rows), std::sqrt(squares)};
  return value.finite() ? value : kNoValue;
}

}  // namespace

bool RolloutValue::finite() const { return std::isfinite(cost) && std::isfinite(violation); }

struct RolloutValues::Impl {
  /// Buffers of one thread.
  struct Thread {
    explicit Thread(const ControlSplines& splines, EvaluationMemory& memory, int index) {
      const ShootingProblem& problem = splines.problem();
      for (int k = 0; k <= problem.knots(); ++k) {
        const auto& model = k < problem.knots() ? problem.phases()[problem.knot(k).phase].model
                                                : problem.terminal().model;
        batches.push_back(memory.of(model).lanes[index].get());
      }
      theta.resize(splines.parameters(), Lane(0.0));
      x.resize(problem.nx(), Lane(0.0));
      rows.assign(kLaneWidth, Eigen::VectorXd::Zero(problem.constraint_rows()));
    }

    std::vector<KnotBatch<Lane>*> batches;  ///< N + 1
    AlignedVector<Lane> theta, x;
    std::vector<Eigen::VectorXd> rows;  ///< constraint values, per lane
  };
  /// Buffers of one thread for motions of a simulator.
  struct Simulated {
    explicit Simulated(const ControlSplines& splines)
        : evaluator(splines.problem()),
          evaluation(splines.problem()),
          trajectory(splines.nominal()) {}

    Evaluator evaluator;
    Evaluation evaluation;
    Trajectory trajectory;
  };

  Impl(const ControlSplines& s, int wanted, Simulate by)
      : splines(s),
        problem(s.problem()),
        simulate(std::move(by)),
        memory(wanted),
        arena(memory.threads()),
        evaluator(problem) {
    for (int t = 0; t < memory.threads(); ++t)
      if (simulate)
        simulated.push_back(std::make_unique<Simulated>(splines));
      else
        threads.push_back(std::make_unique<Thread>(splines, memory, t));
  }

  /// Rolls out samples `first` to `first + kLaneWidth`; missing ones repeat the last one.
  void roll_out_lanes(const Eigen::MatrixXd& theta, int first, Thread& thread,
                      std::vector<RolloutValue>& values) const {
    const int last = static_cast<int>(theta.cols()) - 1, nx = problem.nx();
    for (int p = 0; p < theta.rows(); ++p)
      for (int l = 0; l < kLaneWidth; ++l)
        thread.theta[p].set(l, theta(p, std::min(first + l, last)));
    for (int i = 0; i < nx; ++i) thread.x[i] = Lane(problem.initial_state()[i]);
    Lane cost(0.0), check(0.0);
    for (int k = 0; k <= problem.knots(); ++k) {
      const KnotModel& model = *problem.knot(k).model;
      KnotBatch<Lane>& batch = *thread.batches[k];
      detail::load_knot(problem, k, nullptr, batch);
      if (k < problem.knots()) splines.controls(k, thread.theta.data(), batch.u.data());
      model.evaluate(batch.at(thread.x.data(), batch.u.data()), batch.work);
      cost += batch.work.cost;
      check += cost;
      for (int r = 0; r < model.constraint_rows(); ++r)
        for (int l = 0; l < kLaneWidth; ++l)
          thread.rows[l][problem.constraint_offset(k) + r] = batch.work.constraint[r][l];
      if (k == problem.knots()) break;
      std::ranges::copy(batch.work.next(), thread.x.begin());
      for (int i = 0; i < nx; ++i) check += thread.x[i];
      if (!any_finite(check)) break;
    }
    for (int l = 0; l < kLaneWidth && first + l <= last; ++l)
      values[first + l] =
          std::isfinite(check[l]) ? value_of(problem, cost[l], thread.rows[l]) : kNoValue;
  }

  static bool any_finite(const Lane& numbers) {
    bool any = false;
    for (int l = 0; l < kLaneWidth; ++l) any = any || std::isfinite(numbers[l]);
    return any;
  }

  void write_controls(const double* theta, Trajectory& trajectory) const {
    for (int k = 0; k < problem.knots(); ++k)
      if (problem.nu(k) > 0) splines.controls(k, theta, trajectory.u(k).data());
  }

  RolloutValue value_of_simulated(const double* theta, Simulated& thread) const {
    write_controls(theta, thread.trajectory);
    if (!simulate(thread.trajectory)) return kNoValue;
    thread.evaluator.evaluate(thread.trajectory, thread.evaluation);
    return value_of(problem, thread.evaluation.cost.sum(), thread.evaluation.constraint);
  }

  /// Calls act(i, thread) for 0 … count − 1.
  template <class F>
  void for_each(int count, F act) {
    if (memory.threads() == 1) {
      for (int i = 0; i < count; ++i) act(i, 0);
      return;
    }
    arena.execute([&] {
      tbb::parallel_for(0, count,
                        [&](int i) { act(i, tbb::this_task_arena::current_thread_index()); });
    });
  }

  const ControlSplines& splines;
  const ShootingProblem& problem;
  const Simulate simulate;
  EvaluationMemory memory;
  tbb::task_arena arena;
  Evaluator evaluator;
  std::vector<std::unique_ptr<Thread>> threads;
  std::vector<std::unique_ptr<Simulated>> simulated;
};

RolloutValues::RolloutValues(const ControlSplines& splines, int threads, Simulate simulate)
    : impl_(std::make_unique<Impl>(splines, threads, std::move(simulate))) {}
RolloutValues::~RolloutValues() = default;

void RolloutValues::evaluate(const Eigen::MatrixXd& theta, std::vector<RolloutValue>& values) {
  pass_checkpoint();
  const int count = static_cast<int>(theta.cols());
  if (impl_->simulate)
    return impl_->for_each(count, [&](int i, int thread) {
      values[i] = impl_->value_of_simulated(theta.col(i).data(), *impl_->simulated[thread]);
    });
  impl_->for_each((count + kLaneWidth - 1) / kLaneWidth, [&](int group, int thread) {
    impl_->roll_out_lanes(theta, group * kLaneWidth, *impl_->threads[thread], values);
  });
}

bool RolloutValues::roll_out(const double* theta, Trajectory& trajectory) {
  trajectory = impl_->splines.nominal();
  impl_->write_controls(theta, trajectory);
  if (impl_->simulate) return impl_->simulate(trajectory);
  return impl_->evaluator.simulate(trajectory) < 0;
}

}  // namespace conddp
