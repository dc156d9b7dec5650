#include "loop.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <span>
#include <stdexcept>

#include <fmt/format.h>

namespace py = pybind11;

namespace conddp::python {
namespace {

/// Times within this share of a tick are equal.
constexpr double kSameTime = 1e-6;

}  // namespace

Loop::Loop(const Problem& problem)
    : task_(problem.build_loop()),
      mpc_(std::make_unique<Mpc>(task_->built.problem, task_->built.guess, task_->mpc.controller)),
      last_(-std::numeric_limits<double>::infinity()) {
  mpc_->reserve(task_->mpc.loop.duration);
}

void Loop::prepare() {
  const py::gil_scoped_release released;
  if (!prepared_ && mpc_->goes_on()) mpc_->prepare();
  prepared_ = true;
}

py::array_t<double> Loop::tick(double time, const Numbers& x) {
  const int nx = task_->built.problem->nx();
  if (x.ndim() != 1 || x.shape(0) != nx)
    throw std::invalid_argument(fmt::format("tick: the state must be {} numbers", nx));
  if (!std::isfinite(time) || !std::all_of(x.data(), x.data() + nx, [](double number) {
        return std::isfinite(number);
      }))
    throw std::invalid_argument("tick: time and state must be finite");
  if (time < last_) throw std::invalid_argument("tick: times must not decrease");
  last_ = time;
  const std::span state(x.data(), static_cast<std::size_t>(nx));
  while (mpc_->goes_on() && time + kSameTime * period() >= mpc_->time()) {
    prepare();
    const py::gil_scoped_release released;
    mpc_->feedback(state);
    record_ = mpc_->last_tick();
    prepared_ = false;
  }
  const Eigen::VectorXd& u = mpc_->control(time, x.data());
  py::array_t<double> out(u.size());
  std::copy(u.data(), u.data() + u.size(), out.mutable_data());
  return out;
}

py::dict Loop::last_tick() const {
  const TickRecord& row = record_;
  py::dict out;
  out["tick"] = row.tick;
  out["time_s"] = row.time;
  out["outcome"] = std::string(to_string(row.outcome));
  out["iterations"] = row.iterations;
  out["cost"] = row.cost;
  out["violation"] = row.violation;
  out["fallback"] = row.fallback;
  return out;
}

}  // namespace conddp::python
