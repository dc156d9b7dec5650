#include "solvers/stages/narrow_stage.hpp"

#include <limits>
#include <random>

#include <Eigen/Dense>
#include <gtest/gtest.h>

#include "solvers/stages/value.hpp"
#include "spatial/lane.hpp"

namespace conddp {
namespace {

class NarrowStages : public ::testing::Test {
 protected:
  Eigen::MatrixXd matrix(int rows, int columns) {
    return Eigen::MatrixXd::NullaryExpr(rows, columns, [this] { return normal_(engine_); });
  }
  Eigen::MatrixXd symmetric(int n) {
    const Eigen::MatrixXd B = matrix(n, n);
    return B + B.transpose();
  }
  KnotLinearization knot(int ndx, int nu) {
    KnotLinearization knot;
    knot.ndx = ndx;
    knot.gradient = matrix(ndx + nu, 1);
    knot.hessian.change() = symmetric(ndx + nu);
    knot.F = matrix(ndx, ndx + nu);
    return knot;
  }

 private:
  std::mt19937 engine_{3};
  std::normal_distribution<double> normal_;
};

/// Calls act(ndx, nu) for all sizes that fit a lane.
template <class F>
void for_each_size(F act) {
  for (int ndx = 1; ndx < kLaneWidth; ++ndx)
    for (int nu = 1; ndx + nu <= kLaneWidth; ++nu) act(ndx, nu);
}

TEST_F(NarrowStages, FitALane) {
  for_each_size([](int ndx, int nu) { EXPECT_NE(narrow_stage(ndx, nu), nullptr); });
  for (int nu = 0; nu <= kLaneWidth; ++nu)
    EXPECT_EQ(narrow_stage(kLaneWidth - nu, nu + 1), nullptr);
  EXPECT_EQ(narrow_stage(1, 0), nullptr);
  EXPECT_EQ(narrow_stage(0, 1), nullptr);
}

/// The same knot with extra decoupled states is not narrow.
TEST_F(NarrowStages, PullValuesLikeStagesOfAnySize) {
  for_each_size([&](int ndx, int nu) {
    SCOPED_TRACE(::testing::Message() << ndx << " states, " << nu << " controls");
    const KnotLinearization narrow = knot(ndx, nu);
    ValueFunction next(ndx);
    next.Vxx = symmetric(ndx);
    const int more = kLaneWidth;
    KnotLinearization wide;
    wide.ndx = ndx + more;
    const int nz = wide.ndx + nu;
    wide.gradient = Eigen::VectorXd::Zero(nz);
    wide.F = Eigen::MatrixXd::Zero(wide.ndx, nz);
    Eigen::MatrixXd& hessian = wide.hessian.change();
    hessian = Eigen::MatrixXd::Zero(nz, nz);
    const auto place = [&](int i) { return i < ndx ? i : i + more; };
    for (int j = 0; j < ndx + nu; ++j) {
      for (int i = 0; i < ndx; ++i) wide.F(i, place(j)) = narrow.F(i, j);
      for (int i = 0; i < ndx + nu; ++i) hessian(place(i), place(j)) = narrow.hessian()(i, j);
    }
    ValueFunction beside(wide.ndx);
    beside.Vxx.setZero();
    beside.Vxx.topLeftCorner(ndx, ndx) = next.Vxx;

    ValuePropagation propagation(ndx, nu), any_size(wide.ndx, nu);
    ActionValue q(ndx, nu), expected(wide.ndx, nu);
    propagation.propagate(narrow, next, q);
    any_size.propagate(wide, beside, expected);
    const Eigen::MatrixXd Qzz = q.Qzz(), all = expected.Qzz();
    for (int j = 0; j < ndx + nu; ++j)
      for (int i = j; i < ndx + nu; ++i) EXPECT_EQ(Qzz(i, j), all(place(i), place(j)));
    EXPECT_EQ(Qzz, Eigen::MatrixXd(Qzz.transpose()));
  });
}

TEST_F(NarrowStages, FormTheValueOfAPolicy) {
  for_each_size([&](int ndx, int nu) {
    SCOPED_TRACE(::testing::Message() << ndx << " states, " << nu << " controls");
    ActionValue q(ndx, nu);
    q.resize(nu);
    const Eigen::MatrixXd Qzz = symmetric(ndx + nu);
    q.Qzz() = Qzz;
    q.Qz() = matrix(ndx + nu, 1);
    // The rows below a gain are not read.
    LaneMatrix Kt(ndx + 1, nu);
    Kt.view().setConstant(std::numeric_limits<double>::quiet_NaN());
    const Eigen::MatrixXd K = matrix(nu, ndx);
    Kt.view().topRows(ndx) = K.transpose();
    const Eigen::VectorXd w = matrix(nu, 1), k = matrix(nu, 1);
    ValueFunction value(ndx);
    ASSERT_TRUE(narrow_stage(ndx, nu)->form_value(q, Kt.block(), w.data(), k.data(), value));

    const Eigen::MatrixXd Qxu = Qzz.topRightCorner(ndx, nu);
    const Eigen::MatrixXd Vxx = Qzz.topLeftCorner(ndx, ndx) + K.transpose() * Qxu.transpose();
    const Eigen::VectorXd Vx = q.Qx() + K.transpose() * w + Qxu * k;
    EXPECT_LE((value.Vx - Vx).lpNorm<Eigen::Infinity>(), 1e-12);
    EXPECT_EQ(value.Vxx, Eigen::MatrixXd(value.Vxx.transpose()));
    for (int j = 0; j < ndx; ++j)
      for (int i = j; i < ndx; ++i) EXPECT_NEAR(value.Vxx(i, j), Vxx(i, j), 1e-12);
  });
}

TEST_F(NarrowStages, ReportNonFiniteNumbers) {
  const double nan = std::numeric_limits<double>::quiet_NaN();
  for_each_size([&](int ndx, int nu) {
    SCOPED_TRACE(::testing::Message() << ndx << " states, " << nu << " controls");
    LaneMatrix Kt(ndx + 1, nu);
    const Eigen::VectorXd w = matrix(nu, 1), k = matrix(nu, 1);
    ValueFunction value(ndx);
    for (int bad = 0; bad <= ndx; ++bad) {
      ActionValue q(ndx, nu);
      q.resize(nu);
      q.Qzz() = symmetric(ndx + nu);
      q.Qz() = matrix(ndx + nu, 1);
      const auto form = [&] {
        return narrow_stage(ndx, nu)->form_value(q, Kt.block(), w.data(), k.data(), value);
      };
      EXPECT_TRUE(form());
      if (bad < ndx)
        q.Qzz()(ndx - 1, bad) = nan;
      else
        q.Qz()[ndx - 1] = nan;
      EXPECT_FALSE(form());
    }
  });
}

}  // namespace
}  // namespace conddp
