#pragma once

#include <Eigen/Eigenvalues>
#include <Eigen/LU>
#include <Eigen/SVD>

/// Eigen's decompositions of MatrixXd that several sources use. Each takes seconds to compile, so
/// only `matrix_decompositions.cpp` does. Eigenvalues are covered where the argument is a MatrixXd.
namespace Eigen {

extern template class PartialPivLU<MatrixXd>;
extern template class JacobiSVD<MatrixXd>;
extern template class SelfAdjointEigenSolver<MatrixXd>;
extern template SelfAdjointEigenSolver<MatrixXd>& SelfAdjointEigenSolver<MatrixXd>::compute(
    const EigenBase<MatrixXd>&, int);
extern template class EigenSolver<MatrixXd>;
extern template EigenSolver<MatrixXd>& EigenSolver<MatrixXd>::compute(const EigenBase<MatrixXd>&,
                                                                      bool);

}  // namespace Eigen
