#include "solvers/linalg/row_elimination.hpp"

#include <gtest/gtest.h>

namespace conddp {
namespace {

TEST(RowElimination, MakesNoRowFromRounding) {
  RowElimination system(3, 4);
  system.append() << 3, 0, 4, 1;
  system.append() << 1e-17, 2e-17, 0, 0.5;
  system.append() << 0, 1e-6, 0, 2e-6;
  system.scale();
  EXPECT_TRUE(system.rows().row(0).isApprox(Eigen::RowVector4d(0.6, 0, 0.8, 0.2)));
  EXPECT_TRUE(system.rows().row(1).isApprox(Eigen::RowVector4d(0, 0, 0, 0.5))) << "what it says";
  EXPECT_TRUE(system.rows().row(2).isApprox(Eigen::RowVector4d(0, 1, 0, 2)));
  EXPECT_EQ(system.orthonormalize(0, 0, 3), 2);
}

}  // namespace
}  // namespace conddp
