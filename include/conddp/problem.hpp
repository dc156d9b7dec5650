// Optimal-control problems:
//
//   minimise    Σ_k cost_scale_k ℓ(x_k, u_k) + ℓ_N(x_N)
//   subject to  x_{k+1} = f(x_k, u_k),  x_0 given,  lower ≤ u_k ≤ upper,
//               and the values g of all constraints in their sets.
//
// A KnotModel is the structure that many knots share: system, integrator, costs, constraints,
// bounds. A Phase is a run of knots of one model with the numbers that differ between them. A
// ShootingProblem is an initial state, phases, and a terminal phase of one node without dynamics:
//
//   const auto moving = std::make_shared<KnotModel>(system, Integrator::semi_implicit_euler);
//   moving->add_cost("effort", control_residual(moving->ndx(), moving->nu()), {});
//   moving->set_control_bounds({-5}, {5});
//   const auto end = std::make_shared<KnotModel>(system, Integrator::none);
//   end->add_cost("goal", state_residual(system->manifold()), {});
//
//   Phase phase{.name = "move", .model = moving};
//   for (int k = 0; k < 50; ++k) {
//     phase.dt.push_back(0.02);          // s
//     phase.cost_scale.push_back(0.02);  // running costs are rates
//     phase.parameters.insert(phase.parameters.end(), {0, 0.1});  // reference, weight
//   }
//   ShootingProblem problem(x0, {phase}, goal);
//
// The numbers of a knot stand in `parameters` in the order in which costs and constraints were
// added: of a cost its reference, then its weight; of a constraint what ConstraintTerm says.
//
// Sizes that do not fit throw std::invalid_argument. Once a problem holds a model nothing of it
// changes, except the initial state between two solves (set_initial_state). Trajectories have the
// states x_0 ... x_N and the controls u_0 ... u_{N−1}; create_trajectory() makes one that fits.
#pragma once

#include "ocp/knot/knot_model.hpp"
#include "ocp/problem/problem.hpp"
#include "ocp/problem/trajectory.hpp"
#include "ocp/step/integrator.hpp"
