// Model predictive control: a problem in a closed loop.
//
//   Mpc mpc(problem, guess, {.horizon = 0.6, .tick = 0.01, .solver = "box_fddp"});
//   for (;;) {
//     mpc.prepare();                              // between two measurements
//     const Eigen::VectorXd& u = mpc.feedback(x); // as soon as x is measured
//     ... u, and mpc.control(t, x) where controls change between ticks
//   }
//
// A window slides over the problem's time line by time. Its first guess is the former plan at the
// times of its nodes. With `iterations` the solver makes that many from the predicted state
// (prepare), and the gains correct the first control by what is measured (feedback); without, each
// tick is solved to the solver's tolerances from the measured state. A tick that fails leaves the
// former plan in force, shifted, with its gains.
//
// closed_loop.hpp below simulates such a loop, as `conddp mpc` does.
#pragma once

#include "mpc/closed_loop.hpp"
#include "mpc/mpc.hpp"
