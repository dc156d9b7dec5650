#pragma once

#include <pybind11/numpy.h>
#include <pybind11/pybind11.h>

#include <memory>

#include "mpc/mpc.hpp"
#include "problem.hpp"

namespace conddp::python {

/// Model predictive control by the section `mpc` of a problem, for a plant outside.
class Loop {
 public:
  using Numbers = pybind11::array_t<double, pybind11::array::c_style | pybind11::array::forcecast>;

  explicit Loop(const Problem& problem);

  /// The control at a time (s) and a measured state. If a tick is due, it plans from that state; in
  /// between, the plan in force and its gains act. Times must not decrease.
  pybind11::array_t<double> tick(double time, const Numbers& x);
  /// Does the work for the next tick that precedes its measurement; tick() does it otherwise.
  void prepare();
  /// Time between two plans, s.
  double period() const { return mpc_->options().tick; }
  /// Figures of the last plan.
  pybind11::dict last_tick() const;

 private:
  std::unique_ptr<LoopTask> task_;
  std::unique_ptr<Mpc> mpc_;
  double last_;  ///< time of the last call, s
  bool prepared_ = false;
  TickRecord record_;  ///< of the last plan; that of the loop is of the plan in preparation
};

}  // namespace conddp::python
