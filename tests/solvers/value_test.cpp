#include "solvers/stages/value.hpp"

#include <random>

#include <Eigen/Dense>
#include <gtest/gtest.h>

#include "solvers/linalg/cholesky.hpp"
#include "solvers/stages/gap_transport.hpp"

namespace conddp {
namespace {

class Random {
 public:
  explicit Random(unsigned seed) : engine_(seed) {}
  Eigen::MatrixXd matrix(int rows, int columns) {
    return Eigen::MatrixXd::NullaryExpr(rows, columns, [this] { return normal_(engine_); });
  }
  Eigen::VectorXd vector(int n) { return matrix(n, 1); }
  Eigen::MatrixXd symmetric(int n) {
    const Eigen::MatrixXd B = matrix(n, n);
    return B + B.transpose();
  }

 private:
  std::mt19937 engine_;
  std::normal_distribution<double> normal_;
};

KnotLinearization random_knot(Random& random, int ndx, int nu, bool semi_implicit,
                              std::vector<StateManifold::Segment> curved = {}) {
  KnotLinearization knot;
  knot.ndx = ndx;
  knot.gradient = random.vector(ndx + nu);
  knot.hessian.change() = random.symmetric(ndx + nu);
  knot.F = random.matrix(semi_implicit ? ndx / 2 : ndx, ndx + nu);
  knot.semi_implicit = semi_implicit;
  knot.dt = 0.3;
  knot.curved = std::move(curved);
  for (std::size_t s = 0; s < knot.curved.size(); ++s) {
    knot.A.emplace_back(random.matrix(6, 6));
    knot.H.emplace_back(random.matrix(6, 6));
  }
  return knot;
}

using Part = StateManifold::Part;

/// Knot structures: flat, with one curved block, with two.
std::vector<std::vector<StateManifold::Segment>> curved_layouts() {
  return {{}, {{Part::se3, 0, 0, 6}}, {{Part::so3, 2, 2, 3}, {Part::se3, 7, 6, 6}}};
}

void expect_close(const Eigen::MatrixXd& a, const Eigen::MatrixXd& b, double tolerance = 1e-11) {
  ASSERT_EQ(a.rows(), b.rows());
  ASSERT_EQ(a.cols(), b.cols());
  EXPECT_LE((a - b).lpNorm<Eigen::Infinity>(), tolerance * (1 + b.lpNorm<Eigen::Infinity>()));
}

TEST(ValuePropagation, BothFormsEqualTheDenseFormula) {
  Random random(1);
  for (const auto& curved : curved_layouts()) {
    for (bool semi_implicit : {true, false}) {
      if (!semi_implicit && !curved.empty()) continue;
      for (int nu : {0, 1, 5}) {
        const int ndx = 28;
        const KnotLinearization knot = random_knot(random, ndx, nu, semi_implicit, curved);
        ValueFunction next(ndx);
        next.Vx = random.vector(ndx);
        next.Vxx = random.symmetric(ndx);
        ValuePropagation propagation(ndx, 7);
        ActionValue q(ndx, 7);
        propagation.propagate(knot, next, q);
        const Eigen::MatrixXd T = knot.dense_jacobian();
        expect_close(q.Qz(), knot.gradient + T.transpose() * next.Vx);
        const Eigen::MatrixXd expected = knot.hessian() + T.transpose() * next.Vxx * T;
        const Eigen::MatrixXd lower = q.Qzz().triangularView<Eigen::Lower>();
        expect_close(lower, expected.triangularView<Eigen::Lower>());
        EXPECT_EQ(Eigen::MatrixXd(q.Qxu()),
                  Eigen::MatrixXd(q.Qzz().bottomLeftCorner(nu, ndx).transpose()));
        EXPECT_EQ(Eigen::MatrixXd(q.Quu()), Eigen::MatrixXd(q.Quu().transpose()));
      }
    }
  }
}

TEST(ValuePropagation, SkippingKnownZerosChangesNothing) {
  Random random(6);
  for (const bool semi_implicit : {true, false}) {
    const int ndx = 28, nu = 5, nz = ndx + nu;
    KnotLinearization knot = random_knot(random, ndx, nu, semi_implicit);
    // The diagonal, and some full columns.
    std::vector<std::pair<int, int>> lasting;
    for (int j = 0; j < nz; ++j)
      for (int i = j; i < nz; ++i)
        if (i == j || j % 7 == 0) lasting.emplace_back(i, j);
    KnotHessian hessian(nz, lasting);
    for (const auto& [i, j] : lasting)
      hessian.change(HessianFill::lasting)(i, j) = hessian.change(HessianFill::lasting)(j, i) =
          knot.hessian()(i, j);
    knot.hessian.change() = hessian();
    ValueFunction next(ndx);
    next.Vxx = random.symmetric(ndx);
    ValuePropagation propagation(ndx, nu);
    ActionValue all(ndx, nu), some(ndx, nu);
    propagation.propagate(knot, next, all);
    knot.hessian = hessian;
    propagation.propagate(knot, next, some);
    EXPECT_EQ(Eigen::MatrixXd(all.Qzz().triangularView<Eigen::Lower>()),
              Eigen::MatrixXd(some.Qzz().triangularView<Eigen::Lower>()));
  }
}

TEST(ValuePropagation, SemiImplicitMatchesDenseDynamics) {
  Random random(2);
  for (const auto& curved : curved_layouts()) {
    const int ndx = 28, nu = 4;
    const KnotLinearization knot = random_knot(random, ndx, nu, true, curved);
    KnotLinearization dense = knot;
    dense.semi_implicit = false;
    dense.F = knot.dense_jacobian();
    ValueFunction next(ndx);
    next.Vx = random.vector(ndx);
    next.Vxx = random.symmetric(ndx);
    ValuePropagation propagation(ndx, nu);
    ActionValue a(ndx, nu), b(ndx, nu);
    propagation.propagate(knot, next, a);
    propagation.propagate(dense, next, b);
    expect_close(a.Qz(), b.Qz());
    expect_close(a.Qzz().triangularView<Eigen::Lower>(), b.Qzz().triangularView<Eigen::Lower>());
  }
}

TEST(GapTransport, ValueAfterAGapMovesItsArgument) {
  Random random(4);
  StateManifold manifold;
  manifold.append(Part::flat, 2);
  manifold.append(Part::se3);
  manifold.append(Part::so3);
  const int ndx = manifold.ndx();
  GapTransport transport(manifold);
  const Eigen::VectorXd gap = 0.5 * random.vector(ndx);
  transport.set(gap);
  ValueFunction value(ndx);
  value.Vx = random.vector(ndx);
  value.Vxx = random.symmetric(ndx);
  ValueFunction pulled = value;
  transport.pull(pulled);
  const auto at = [](const ValueFunction& v, const Eigen::VectorXd& d) {
    return v.Vx.dot(d) + 0.5 * d.dot(v.Vxx * d);
  };
  const double constant = at(value, gap);
  for (int trial = 0; trial < 5; ++trial) {
    const Eigen::VectorXd df = random.vector(ndx);
    Eigen::VectorXd moved = df;
    transport.push(moved);
    EXPECT_NEAR(at(value, moved) - constant, at(pulled, df), 1e-10);
  }
}

TEST(GapTransport, PropagationOverAGapMatchesPulledValue) {
  Random random(7);
  StateManifold manifold;
  manifold.append(Part::se3);
  manifold.append(Part::flat, 2);
  manifold.append(Part::so3);
  manifold.append(Part::flat, 3 + 14);
  const int ndx = manifold.ndx(), nu = 4;
  GapTransport transport(manifold);
  ValuePropagation propagation(ndx, nu);
  for (const double size : {0.5, 0.0}) {
    transport.set(size * random.vector(ndx));
    for (const bool semi_implicit : {true, false}) {
      const auto curved = semi_implicit ? manifold.curved() : std::vector<StateManifold::Segment>();
      const KnotLinearization knot = random_knot(random, ndx, nu, semi_implicit, curved);
      ValueFunction next(ndx);
      next.Vx = random.vector(ndx);
      next.Vxx = random.symmetric(ndx);
      ActionValue over(ndx, nu), from_pulled(ndx, nu);
      propagation.propagate(knot, next, over, &transport);
      transport.pull(next);
      propagation.propagate(knot, next, from_pulled);
      expect_close(over.Qz(), from_pulled.Qz());
      expect_close(over.Qzz().triangularView<Eigen::Lower>(),
                   from_pulled.Qzz().triangularView<Eigen::Lower>());
    }
  }
}

// x⁺ = f ⊕ (α − 1) gap with f = (x⁺_old ⊕ gap) ⊕ ε δf: derivatives with respect to ε and α at (0,
// 0).
TEST(GapTransport, IsTheDerivativeOfTheContractedState) {
  Random random(5);
  StateManifold manifold;
  manifold.append(Part::se3);
  manifold.append(Part::so3);
  manifold.append(Part::flat, 1);
  const int ndx = manifold.ndx();
  const Eigen::VectorXd gap = 0.8 * random.vector(ndx), df = random.vector(ndx);
  std::vector<double> neutral = manifold.neutral();
  Eigen::VectorXd old(manifold.nx()), f(manifold.nx()), moved(manifold.nx());
  const Eigen::VectorXd anywhere = random.vector(ndx);
  manifold.integrate(neutral.data(), anywhere.data(), old.data());
  manifold.integrate(old.data(), gap.data(), f.data());
  const auto next = [&](double h) {
    Eigen::VectorXd step = h * df, back = (h - 1) * gap, out(manifold.nx()), delta(ndx);
    manifold.integrate(f.data(), step.data(), moved.data());
    manifold.integrate(moved.data(), back.data(), out.data());
    manifold.difference(old.data(), out.data(), delta.data());
    return delta;
  };
  const double h = 1e-5;
  const Eigen::VectorXd numeric = (next(h) - next(-h)) / (2 * h);
  GapTransport transport(manifold);
  transport.set(gap);
  Eigen::VectorXd delta = df;
  transport.push(delta);
  expect_close(delta, numeric, 1e-8);
}

bool factor(const Eigen::MatrixXd& A, LaneMatrix& L) {
  L.view() = A;
  return cholesky_in_place(L.block());
}

TEST(Cholesky, SolvesRows) {
  Random random(6);
  for (const int n : {0, 1, 5, 6, 7, 8, 12, 13, 23}) {
    const Eigen::MatrixXd B = random.matrix(n, n);
    const Eigen::MatrixXd A = B * B.transpose() + Eigen::MatrixXd::Identity(n, n);
    LaneMatrix factors(n, n);
    ASSERT_TRUE(factor(A, factors));
    const Eigen::MatrixXd L = factors.view().triangularView<Eigen::Lower>();
    expect_close(L * L.transpose(), A);
    for (const int rows : {1, 4, 19, 37, 77}) {
      const Eigen::MatrixXd rhs = random.matrix(rows, n);
      LaneMatrix X(rows, n);
      X.view() = rhs;
      solve_rows_in_place(factors.block(), X.block());
      expect_close(X.view() * A, rhs);
    }
  }
}

TEST(Cholesky, RejectsIndefiniteMatrices) {
  Random random(7);
  const Eigen::MatrixXd B = random.matrix(7, 7);
  const Eigen::MatrixXd A = B * B.transpose() + Eigen::MatrixXd::Identity(7, 7);
  LaneMatrix L(7, 7);
  ASSERT_TRUE(factor(A, L));
  Eigen::MatrixXd indefinite = A;
  indefinite(6, 6) = -1;
  EXPECT_FALSE(factor(indefinite, L));
  Eigen::MatrixXd singular = random.matrix(7, 3);
  singular = (singular * singular.transpose()).eval();
  EXPECT_FALSE(factor(singular, L));
  Eigen::MatrixXd nan = A;
  nan(2, 2) = std::numeric_limits<double>::quiet_NaN();
  EXPECT_FALSE(factor(nan, L));
}

}  // namespace
}  // namespace conddp
