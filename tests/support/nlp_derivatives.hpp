#pragma once

#include <random>

#include <gtest/gtest.h>

#include "nlp/nonlinear_program.hpp"

namespace conddp::testing {

inline Eigen::VectorXd random_vector(Eigen::Index n, std::mt19937_64& engine) {
  std::uniform_real_distribution<double> number(-1, 1);
  return Eigen::VectorXd::NullaryExpr(n, [&] { return number(engine); });
}

/// Jᵀ m and J d of a program at its current point.
inline Eigen::VectorXd jacobian_times(NonlinearProgram& program, const Eigen::VectorXd& d,
                                      bool transposed) {
  Eigen::VectorXd values(program.jacobian_structure().size());
  program.jacobian(values.data());
  Eigen::VectorXd out = Eigen::VectorXd::Zero(transposed ? program.variables() : program.rows());
  for (int i = 0; i < values.size(); ++i) {
    const int row = program.jacobian_structure().rows[i];
    const int column = program.jacobian_structure().columns[i];
    if (transposed)
      out[column] += values[i] * d[row];
    else
      out[row] += values[i] * d[column];
  }
  return out;
}

inline Eigen::VectorXd hessian_times(NonlinearProgram& program, double weight,
                                     const Eigen::VectorXd& multipliers, const Eigen::VectorXd& d) {
  Eigen::VectorXd values(program.hessian_structure().size());
  program.hessian(weight, multipliers.data(), values.data());
  Eigen::VectorXd out = Eigen::VectorXd::Zero(d.size());
  for (int i = 0; i < values.size(); ++i) {
    const int row = program.hessian_structure().rows[i];
    const int column = program.hessian_structure().columns[i];
    out[row] += values[i] * d[column];
    if (row != column) out[column] += values[i] * d[row];
  }
  return out;
}

inline Eigen::VectorXd lagrangian_gradient(NonlinearProgram& program, double weight,
                                           const Eigen::VectorXd& multipliers) {
  Eigen::VectorXd gradient(program.variables());
  program.gradient(gradient.data());
  return weight * gradient + jacobian_times(program, multipliers, true);
}

/// Compares gradient, Jacobian, and Hessian along a random direction with central differences, to
/// `tolerance` of the largest entry.
inline void check_derivatives(NonlinearProgram& program, const Eigen::VectorXd& y,
                              std::mt19937_64& engine, double tolerance) {
  constexpr double kStep = 1e-5;
  const Eigen::VectorXd d = random_vector(program.variables(), engine);
  const Eigen::VectorXd multipliers = random_vector(program.rows(), engine);
  const double weight = 0.7;
  const auto at = [&](double step) {
    const Eigen::VectorXd moved = y + step * d;
    program.set_point(moved.data());
    struct {
      double f;
      Eigen::VectorXd g, gradient;
    } values{program.objective(), Eigen::VectorXd(program.rows()), {}};
    program.constraints(values.g.data());
    values.gradient = lagrangian_gradient(program, weight, multipliers);
    return values;
  };
  const auto ahead = at(kStep), behind = at(-kStep);
  program.set_point(y.data());
  Eigen::VectorXd gradient(program.variables());
  program.gradient(gradient.data());
  const double slope = (ahead.f - behind.f) / (2 * kStep);
  EXPECT_NEAR(gradient.dot(d), slope, tolerance * gradient.cwiseAbs().dot(d.cwiseAbs()));
  const Eigen::VectorXd rows = (ahead.g - behind.g) / (2 * kStep);
  EXPECT_LE((jacobian_times(program, d, false) - rows).lpNorm<Eigen::Infinity>(),
            tolerance * std::max(1.0, rows.lpNorm<Eigen::Infinity>()));
  for (const double w : {weight, 0.0}) {
    Eigen::VectorXd curve = (ahead.gradient - behind.gradient) / (2 * kStep);
    if (w == 0) {
      // Without the cost: the total minus the cost's own curvature.
      curve -= hessian_times(program, weight, Eigen::VectorXd::Zero(program.rows()), d);
    }
    EXPECT_LE((hessian_times(program, w, multipliers, d) - curve).lpNorm<Eigen::Infinity>(),
              tolerance * std::max(1.0, ahead.gradient.lpNorm<Eigen::Infinity>() +
                                            curve.lpNorm<Eigen::Infinity>()))
        << "weight " << w;
  }
}

}  // namespace conddp::testing
