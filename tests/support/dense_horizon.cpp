#include "support/dense_horizon.hpp"

namespace conddp::testing {

DenseHorizon::DenseHorizon(const Linearization& linearization, bool open) {
  ndx = linearization.knots.front().ndx;
  int n = 0, controls = 0;
  for (const KnotLinearization& knot : linearization.knots) {
    offset.push_back(n);
    nu.push_back(knot.nu());
    n += ndx + knot.nu();
    controls += knot.nu();
  }
  H.setZero(n, n);
  g.setZero(n);
  E.setZero(nodes() * ndx, n);
  e.setZero(nodes() * ndx);
  S.setZero(n, controls);
  s.setZero(n);
  const Eigen::MatrixXd one = Eigen::MatrixXd::Identity(ndx, ndx);
  E.topLeftCorner(ndx, ndx) = -one;
  for (int k = 0, control = 0; k < nodes(); ++k) {
    const KnotLinearization& knot = linearization.knots[k];
    H.block(offset[k], offset[k], nz(k), nz(k)) = knot.hessian();
    g.segment(offset[k], nz(k)) = knot.gradient;
    S.block(offset[k] + ndx, control, nu[k], nu[k]).setIdentity();
    control += nu[k];
    if (k + 1 == nodes()) break;
    const Eigen::MatrixXd J = knot.dense_jacobian();
    const int row = (k + 1) * ndx, next = offset[k + 1];
    E.block(row, offset[k], ndx, nz(k)) = J;
    E.block(row, next, ndx, ndx) = -one;
    S.middleRows(next, ndx) = J * S.middleRows(offset[k], nz(k));
    s.segment(next, ndx) = J * s.segment(offset[k], nz(k));
    if (!open) continue;
    e.segment(row, ndx) = -linearization.gap.col(k);
    s.segment(next, ndx) += linearization.gap.col(k);
  }
}

Eigen::VectorXd DenseHorizon::stack(const std::vector<Eigen::VectorXd>& z) const {
  Eigen::VectorXd all(size());
  for (int k = 0; k < nodes(); ++k) all.segment(offset[k], nz(k)) = z[k];
  return all;
}

DenseHorizon::Optimum DenseHorizon::minimum(const Eigen::MatrixXd& A,
                                            const Eigen::VectorXd& b) const {
  const int n = size(), m = static_cast<int>(e.size()), rows = static_cast<int>(b.size());
  Eigen::MatrixXd K = Eigen::MatrixXd::Zero(n + m + rows, n + m + rows);
  K.topLeftCorner(n, n) = H;
  K.block(n, 0, m, n) = E;
  K.block(0, n, n, m) = E.transpose();
  K.block(n + m, 0, rows, n) = A;
  K.block(0, n + m, n, rows) = A.transpose();
  Eigen::VectorXd rhs(n + m + rows);
  rhs << -g, e, -b;
  const Eigen::VectorXd solution = K.fullPivLu().solve(rhs);
  return {solution.head(n), solution.segment(n, m).reshaped(ndx, nodes()), solution.tail(rows)};
}

Eigen::MatrixXd dense_constraints(const ShootingProblem& problem,
                                  const Linearization& linearization) {
  int columns = 0;
  for (const KnotLinearization& knot : linearization.knots)
    columns += static_cast<int>(knot.gradient.size());
  Eigen::MatrixXd C = Eigen::MatrixXd::Zero(problem.constraint_rows(), columns);
  int column = 0;
  for (int k = 0; k <= problem.knots(); ++k) {
    const Eigen::MatrixXd& here = linearization.knots[k].C;
    C.block(problem.constraint_offset(k), column, here.rows(), here.cols()) = here;
    column += static_cast<int>(linearization.knots[k].gradient.size());
  }
  return C;
}

Eigen::VectorXd DensePenalty::outside(const Eigen::VectorXd& z) const {
  const Eigen::VectorXd values = C * z + base;
  return values - values.cwiseMin(upper).cwiseMax(lower);
}

double DensePenalty::value(const Eigen::VectorXd& z) const {
  return 0.5 * penalty.dot(outside(z).cwiseAbs2());
}

Eigen::VectorXd DensePenalty::gradient(const Eigen::VectorXd& z) const {
  return C.transpose() * penalty.cwiseProduct(outside(z));
}

Added affine_rows(const Eigen::MatrixXd& C, const ShootingProblem& problem, int first, int last,
                  double lower, double upper) {
  const std::size_t rows = C.rows();
  return {.name = "rows " + std::to_string(first),
          .residual = std::make_shared<AffineResidual>(C, problem.nx()),
          .reference = std::vector<double>(rows, 0.0),
          .lower = std::vector<double>(rows, lower),
          .upper = std::vector<double>(rows, upper),
          .first = first,
          .last = last};
}

void DensePenalty::add_to(Linearization& linearization) const {
  const Eigen::VectorXd zero = Eigen::VectorXd::Zero(C.cols());
  const Eigen::VectorXd slope = gradient(zero);
  const Eigen::VectorXd weight = (outside(zero).array() != 0).cast<double>() * penalty.array();
  const Eigen::MatrixXd curvature = C.transpose() * weight.asDiagonal() * C;
  Eigen::Index at = 0;
  for (KnotLinearization& knot : linearization.knots) {
    const Eigen::Index nz = knot.gradient.size();
    knot.gradient += slope.segment(at, nz);
    knot.hessian.change() += curvature.block(at, at, nz, nz);
    at += nz;
  }
}

ShootingProblem rows_at_all_nodes(const LinearQuadratic& lq, int rows, double lower, double upper) {
  const ShootingProblem& free = *lq.problem;
  const int N = free.knots();
  std::vector<Added> added;
  for (int first = 0; first < N;) {
    int last = first;
    while (last + 1 < N && free.knot(last + 1).phase == free.knot(first).phase) ++last;
    const Eigen::MatrixXd C = Eigen::MatrixXd::Ones(rows, free.nx() + free.nu(first));
    added.push_back(affine_rows(C, free, first, last, lower, upper));
    first = last + 1;
  }
  added.push_back(affine_rows(Eigen::MatrixXd::Ones(rows, free.nx()), free, N, N, lower, upper));
  return with_constraints(free, added);
}

DensePenalty penalty_of_rows(const ShootingProblem& problem, const Linearization& linearization,
                             const Augmentation& augmentation) {
  const int rows = problem.constraint_rows();
  DensePenalty penalty{dense_constraints(problem, linearization),
                       linearization.constraint + augmentation.shift, augmentation.penalty,
                       Eigen::VectorXd(rows), Eigen::VectorXd(rows)};
  for (const NodeConstraint& c : problem.constraints())
    for (int i = 0; i < c.term->rows; ++i) {
      penalty.lower[c.row + i] = c.lower[i];
      penalty.upper[c.row + i] = c.upper[i];
    }
  return penalty;
}

void randomize(const ShootingProblem& problem, RandomNumbers& random,
               Linearization& linearization) {
  const auto fill = [&](auto&& matrix, double size) {
    for (double& value : matrix.reshaped()) value = random.uniform(-size, size);
  };
  for (KnotLinearization& knot : linearization.knots) {
    const int nz = static_cast<int>(knot.gradient.size());
    Eigen::MatrixXd root(nz, nz);
    fill(root, 1);
    knot.hessian.change() = root * root.transpose() + 0.3 * Eigen::MatrixXd::Identity(nz, nz);
    fill(knot.gradient, 1);
    fill(knot.F, 0.7);
    fill(knot.C, 1);
  }
  fill(linearization.gap, 1);
  for (const NodeConstraint& c : problem.constraints())
    fill(linearization.constraint.segment(c.row, c.term->rows), 1);
}

}  // namespace conddp::testing
