#include "solvers/riccati/null_space_stage.hpp"

#include <algorithm>
#include <cmath>

#include "solvers/linalg/cholesky.hpp"

namespace conddp {

NullSpaceStage::NullSpaceStage(const ShootingProblem& problem)
    : problem_(problem),
      nodes_(problem.knots() + 1),
      multipliers_(Eigen::VectorXd::Zero(problem.constraint_rows())) {
  assign_rows();
  const int ndx = problem.ndx();
  int largest_rows = 0, largest_nu = 0;
  for (int k = 0; k <= problem.knots(); ++k) {
    Node& node = nodes_[k];
    const bool has_next = k < problem.knots();
    const int nu = has_next ? problem.nu(k) : 0;
    const int rows = static_cast<int>(node.rows.size()) + (has_next ? ndx : 0);
    node.system = RowElimination(rows, nu + ndx + 1);
    node.Quu.resize(nu, nu);
    node.Qxu.resize(ndx, nu);
    node.Qu.resize(nu);
    largest_rows = std::max(largest_rows, rows);
    largest_nu = std::max(largest_nu, nu);
  }
  for (Eigen::MatrixXd* m : {&basis_, &QZ_}) m->resize(largest_nu, largest_nu);
  reduced_ = LaneMatrix(largest_nu, largest_nu);
  affine_.resize(largest_nu, ndx + 1);
  product_ = rhs_ = affine_;
  for (Eigen::VectorXd* v : {&row_, &pulled_}) v->resize(ndx + largest_nu);
  costate_.resize(ndx);
  for (Eigen::VectorXd* v : {&eta_, &y_, &above_}) v->resize(largest_rows);
  gradient_.resize(largest_nu);
}

/// Assigns all constraint rows but free ones to their nodes.
void NullSpaceStage::assign_rows() {
  for (const NodeConstraint& c : problem_.constraints()) {
    for (int r = 0; r < c.term->rows; ++r) {
      if (std::isinf(c.lower[r])) continue;
      nodes_[c.node].rows.push_back(c.row + r);
      nodes_[c.node].target.push_back(c.lower[r]);
    }
  }
}

void NullSpaceStage::begin_horizon(const Linearization& linearization, const Gaps& gaps) {
  linearization_ = &linearization;
  gaps_ = &gaps;
  contradiction_ = 0;
  const int N = problem_.knots();
  collect(N);
  eliminate(N, 0);
}

/// Collects the rows of a node's constraints and, at a knot, the rows passed on by the next node.
void NullSpaceStage::collect(int k) {
  Node& node = nodes_[k];
  const KnotLinearization& knot = linearization_->knots[k];
  const int ndx = problem_.ndx(), nu = knot.nu();
  node.system.clear();
  for (std::size_t i = 0; i < node.rows.size(); ++i) {
    auto row = node.system.append();
    const auto C = knot.C.row(node.rows[i] - problem_.constraint_offset(k));
    row.head(nu) = C.tail(nu);
    row.segment(nu, ndx) = C.head(ndx);
    row[nu + ndx] = linearization_->constraint[node.rows[i]] - node.target[i];
  }
  if (k == problem_.knots()) return;
  const Node& next = nodes_[k + 1];
  const int next_nu = linearization_->knots[k + 1].nu();
  for (int i = 0; i < next.passed; ++i) {
    const auto from = next.system.rows().row(next.used + i);
    costate_ = from.segment(next_nu, ndx).transpose();
    auto row = node.system.append();
    row[nu + ndx] = from[next_nu + ndx];
    if (!(*gaps_)[k].closed()) {
      row[nu + ndx] += costate_.dot(linearization_->gap.col(k));
      (*gaps_)[k].pull(costate_);
    }
    auto pulled = pulled_.head(ndx + nu);
    knot.apply_transpose(costate_, pulled, row_.head(ndx));
    row.head(nu) = pulled.tail(nu).transpose();
    row.segment(nu, ndx) = pulled.head(ndx).transpose();
  }
}

void NullSpaceStage::eliminate(int k, int nu) {
  Node& node = nodes_[k];
  const int ndx = problem_.ndx();
  node.system.scale();
  node.used = node.system.orthonormalize(0, 0, nu);
  // The initial state is given.
  node.passed = k == 0 ? 0 : node.system.orthonormalize(node.used, nu, ndx);
  const auto rows = node.system.rows();
  for (int i = node.used + node.passed; i < node.system.count(); ++i)
    contradiction_ = std::max(contradiction_, std::abs(rows(i, nu + ndx)));
}

void NullSpaceStage::pass(int knot) {
  collect(knot);
  eliminate(knot, 0);
}

/// Q₁ comes from the rows. Orthogonalized unit vectors complete it, the most different ones first.
void NullSpaceStage::complete_basis(const Node& node, int nu) {
  basis_.topLeftCorner(nu, node.used) = node.system.rows().topLeftCorner(node.used, nu).transpose();
  for (int j = node.used; j < nu; ++j) {
    const auto known = basis_.topLeftCorner(nu, j);
    int best = 0;
    known.rowwise().squaredNorm().minCoeff(&best);
    auto column = basis_.col(j).head(nu);
    column = Eigen::VectorXd::Unit(nu, best);
    for (int twice = 0; twice < 2; ++twice)
      for (int i = 0; i < j; ++i) column -= known.col(i).dot(column) * known.col(i);
    column.normalize();
  }
}

bool NullSpaceStage::solve(const StageProblem& stage, Eigen::Ref<Eigen::VectorXd> k,
                           const LaneBlock& Kt) {
  const int nu = Kt.cols, ndx = Kt.rows - 1;
  Node& node = nodes_[stage.knot];
  collect(stage.knot);
  eliminate(stage.knot, nu);
  node.Quu = stage.Quu;
  node.Qxu = stage.Qxu;
  node.Qu = stage.Qu;
  complete_basis(node, nu);
  const int r = node.used, free = nu - r;
  // The columns belong to δx and, last, to the constant 1.
  auto affine = affine_.topRows(nu);
  affine.noalias() = -basis_.topLeftCorner(nu, r) * node.system.rows().block(0, nu, r, ndx + 1);
  if (free > 0) {
    const auto Z = basis_.block(0, r, nu, free);
    auto product = product_.topRows(nu);
    product.leftCols(ndx) = node.Qxu.transpose();
    product.col(ndx) = node.Qu;
    if (r > 0) product.noalias() += node.Quu * affine;
    auto rhs = rhs_.topRows(free);
    rhs.noalias() = -Z.transpose() * product;
    reduced_.resize(free, free);
    auto reduced = reduced_.view();
    auto QZ = QZ_.topLeftCorner(nu, free);
    QZ.noalias() = node.Quu * Z;
    reduced.noalias() = Z.transpose() * QZ;
    if (!cholesky_in_place(reduced_.block())) return false;
    reduced.triangularView<Eigen::Lower>().solveInPlace(rhs);
    reduced.transpose().triangularView<Eigen::Upper>().solveInPlace(rhs);
    affine.noalias() += Z * rhs;
  }
  Kt.view().topRows(ndx) = affine.leftCols(ndx).transpose();
  k = affine.col(ndx);
  return true;
}

const Eigen::VectorXd& NullSpaceStage::find_multipliers(const LinearRollout& step) {
  // Number of rows that this node passed to the previous one; above_ holds their multipliers.
  int passed = 0;
  for (int k = 0; k <= problem_.knots(); ++k) {
    Node& node = nodes_[k];
    const int nu = k < problem_.knots() ? problem_.nu(k) : 0, count = node.system.count();
    auto eta = eta_.head(count);
    eta.setZero();
    if (nu > 0) {
      auto gradient = gradient_.head(nu);
      gradient = node.Qu;
      gradient.noalias() += node.Quu * step.du(k);
      gradient.noalias() += node.Qxu.transpose() * step.dx(k);
      eta.head(node.used).noalias() = -node.system.rows().topLeftCorner(node.used, nu) * gradient;
    }
    eta.segment(node.used, passed) = above_.head(passed);
    auto y = y_.head(count);
    node.system.original_multipliers(eta, y);
    const int own = static_cast<int>(node.rows.size());
    for (int i = 0; i < own; ++i) multipliers_[node.rows[i]] = y[i];
    passed = count - own;
    above_.head(passed) = y.tail(passed);
  }
  return multipliers_;
}

}  // namespace conddp
