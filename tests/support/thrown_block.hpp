#pragma once

#include <gtest/gtest.h>

#include "analysis/contact/contact_motion.hpp"
#include "analysis/contact/contact_simulator.hpp"
#include "support/contact_plants.hpp"

namespace conddp {

/// A block that is thrown, lands, slides, and stops, with dry friction and a stop along x.
inline ContactMotion thrown_block() {
  ContactMotion motion;
  motion.plant = block_on_slope(0.5);
  const int x = motion.plant.robot->find_joint("base_x").value();
  motion.plant.contacts.stops = {{x, -kUnlimited, 0.3}};
  motion.plant.contacts.frictions = {{x, 0.2}};
  StepStart start = at_rest(motion.plant, 0.01);
  start.q[1] = 0.6;
  start.v << 2, 0, 0;
  motion.q.push_back(start.q);
  motion.v.push_back(start.v);
  ContactSimulator simulator(motion.plant);
  for (int k = 0; k < 60; ++k) {
    motion.u.push_back(Eigen::VectorXd::Constant(1, k > 40 ? 2 : 0));
    start.applied = motion.applied(motion.u.back());
    const ContactStep step = simulator.step(start);
    EXPECT_EQ(step.status, StepStatus::solved);
    motion.h.push_back(start.h);
    motion.q.push_back(start.q = step.q);
    motion.v.push_back(start.v = step.v);
    motion.forces.push_back(step.forces);
  }
  motion.u_lower = Eigen::VectorXd::Constant(1, -5);
  motion.u_upper = Eigen::VectorXd::Constant(1, 5);
  return motion;
}

}  // namespace conddp
