#include "solvers/linalg/riccati_equation.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>

#include "base/matrix_decompositions.hpp"
#include "solvers/common/tuning.hpp"

namespace conddp {
namespace {

using Matrix = Eigen::MatrixXd;
constexpr double kEpsilon = std::numeric_limits<double>::epsilon();

Matrix symmetric(const Matrix& M) { return 0.5 * (M + M.transpose()); }

/// Scales columns to length 1; zero columns stay.
Matrix normalized_columns(Matrix M) {
  for (int j = 0; j < M.cols(); ++j)
    if (const double norm = M.col(j).norm(); norm > 0) M.col(j) /= norm;
  return M;
}

/// Orthonormal basis of the directions that a block adds to the span of an orthonormal V.
Matrix new_directions(const Matrix& V, Matrix block, double scale) {
  if (block.cols() == 0) return block;
  for (int pass = 0; pass < 2; ++pass) block -= V * (V.transpose() * block);
  const Eigen::JacobiSVD<Matrix> svd(block, Eigen::ComputeThinU);
  const int rank =
      static_cast<int>((svd.singularValues().array() > tuning::kRounding * scale).count());
  return svd.matrixU().leftCols(rank);
}

/// Orthonormal basis of the states that the controls reach.
Matrix reachable_space(const Matrix& A, const Matrix& B) {
  const double scale = std::max(1.0, A.norm());
  Matrix V(A.rows(), 0);
  Matrix added = new_directions(V, normalized_columns(B), 1);
  while (added.cols() > 0 && V.cols() < A.rows()) {
    Matrix wider(A.rows(), V.cols() + added.cols());
    wider << V, added;
    V = std::move(wider);
    added = new_directions(V, A * added, scale);
  }
  return V;
}

LinearMode make_mode(std::complex<double> eigenvalue, const Eigen::VectorXcd& vector) {
  const Eigen::VectorXd share = vector.cwiseAbs();
  return {eigenvalue, share / share.maxCoeff()};
}

/// The slowest mode that does not decay, if any.
std::optional<LinearMode> lasting(const std::vector<LinearMode>& modes) {
  const auto slowest = std::max_element(
      modes.begin(), modes.end(),
      [](const auto& a, const auto& b) { return std::abs(a.eigenvalue) < std::abs(b.eigenvalue); });
  if (slowest == modes.end() || std::abs(slowest->eigenvalue) < 1 - std::sqrt(tuning::kUlps))
    return std::nullopt;
  return *slowest;
}

/// Smallest eigenvalue of a symmetric matrix scaled to a unit diagonal (where it is positive).
double least_eigenvalue(const Matrix& M) {
  if (M.size() == 0) return 1;
  const Eigen::VectorXd scale =
      M.diagonal().unaryExpr([](double d) { return d > 0 ? 1 / std::sqrt(d) : 1.0; });
  const Matrix C = scale.asDiagonal() * M * scale.asDiagonal();
  return Eigen::SelfAdjointEigenSolver<Matrix>(C, Eigen::EigenvaluesOnly).eigenvalues()[0];
}

/// The problem without its cross term, by u = v − R⁻¹Sᵀx.
struct Separated {
  Matrix A, Q;
  Eigen::LLT<Matrix> R;
};

Separated separate(const RegulatorProblem& p) {
  Separated s{p.A, p.Q, Eigen::LLT<Matrix>(p.R)};
  const Matrix shift = s.R.solve(p.S.transpose());
  s.A -= p.B * shift;
  s.Q = symmetric(p.Q - p.S * shift);
  return s;
}

/// Limit of the cost matrix as the horizon is doubled.
Matrix double_horizons(const Separated& s, const Matrix& B) {
  constexpr int kMost = 60;
  const int n = static_cast<int>(B.rows());
  Matrix A = s.A, G = symmetric(B * s.R.solve(B.transpose())), H = s.Q;
  for (int k = 0; k < kMost; ++k) {
    const Eigen::PartialPivLU<Matrix> W(Matrix::Identity(n, n) + G * H);
    const Matrix WA = W.solve(A), WG = W.solve(G);
    const Matrix more = symmetric(A.transpose() * H * WA);
    G = symmetric(G + A * WG * A.transpose());
    A = A * WA;
    H += more;
    if (!H.allFinite() || more.norm() <= kEpsilon * H.norm()) break;
  }
  return H;
}

Matrix gain(const RegulatorProblem& p, const Matrix& P) {
  const Matrix PB = P * p.B;
  return symmetric(p.R + p.B.transpose() * PB).ldlt().solve(PB.transpose() * p.A + p.S.transpose());
}

/// Cost of the regulator with this gain: Σ (A − BK)ᵏᵀ M (A − BK)ᵏ, doubling the number of terms.
Matrix cost_of(const RegulatorProblem& p, const Matrix& K) {
  constexpr int kMost = 60;
  const Matrix SK = p.S * K;
  Matrix power = p.A - p.B * K;
  Matrix P = symmetric(p.Q - SK - SK.transpose() + K.transpose() * p.R * K);
  for (int k = 0; k < kMost; ++k) {
    const Matrix more = symmetric(power.transpose() * P * power);
    P += more;
    power = power * power;
    if (!P.allFinite() || more.norm() <= tuning::kTighter * kEpsilon * P.norm()) break;
  }
  return P;
}

double relative_residual(const RegulatorProblem& p, const Matrix& P) {
  const Matrix PA = P * p.A;
  const Matrix cross = PA.transpose() * p.B + p.S;
  const Matrix defect = p.Q + p.A.transpose() * PA - cross * gain(p, P) - P;
  const double largest = P.cwiseAbs().maxCoeff();
  return defect.cwiseAbs().maxCoeff() / (largest > 0 ? largest : 1);
}

/// Takes steps of Newton's method as long as they reduce the residual.
void refine(const RegulatorProblem& p, Matrix& P, double& residual) {
  constexpr int kMost = 4;
  for (int i = 0; i < kMost; ++i) {
    Matrix next = cost_of(p, gain(p, P));
    const double own = next.allFinite() ? relative_residual(p, next) : residual;
    if (!(own < residual)) return;
    P = std::move(next);
    residual = own;
  }
}

/// Eigenvalues by descending modulus; of a conjugate pair, the one above the real axis comes first.
Eigen::VectorXcd sorted_eigenvalues(const Matrix& M) {
  Eigen::VectorXcd values = M.eigenvalues();
  std::stable_sort(values.begin(), values.end(), [](const auto& a, const auto& b) {
    const double x = std::abs(a), y = std::abs(b);
    return std::abs(x - y) > tuning::kRounding * (x + y) ? x > y : a.imag() > b.imag();
  });
  return values;
}

/// Finds the reason why a problem lacks a regulator, before anything is solved.
RegulatorResult find_fault(const RegulatorProblem& p) {
  RegulatorResult result;
  result.eigenvalue = least_eigenvalue(p.R);
  if (!(result.eigenvalue > tuning::kExact)) {
    result.fault = RegulatorFault::control_cost;
    return result;
  }
  const Separated s = separate(p);
  result.eigenvalue = least_eigenvalue(s.Q);
  if (!(result.eigenvalue >= -tuning::kExact)) {
    result.fault = RegulatorFault::state_cost;
    return result;
  }
  result.mode = lasting(unreachable_modes(p.A, p.B));
  if (result.mode) {
    result.fault = RegulatorFault::not_stabilizable;
    return result;
  }
  result.mode = lasting(unreachable_modes(s.A.transpose(), s.Q));
  if (result.mode) result.fault = RegulatorFault::not_detectable;
  return result;
}

}  // namespace

std::vector<LinearMode> unreachable_modes(const Matrix& A, const Matrix& B) {
  const int n = static_cast<int>(A.rows());
  const Matrix V = reachable_space(A, B);
  const int reached = static_cast<int>(V.cols());
  if (reached == n) return {};
  Matrix W = Matrix::Identity(n, n);
  if (reached > 0) {
    const Eigen::HouseholderQR<Matrix> qr(V);
    W = qr.householderQ() * W;
  }
  const Matrix rest = W.rightCols(n - reached);
  const Matrix block = (rest.transpose() * A * rest).transpose();
  const Eigen::EigenSolver<Matrix> eigen(block);
  std::vector<LinearMode> modes;
  for (int i = 0; i < n - reached; ++i)
    modes.push_back(make_mode(eigen.eigenvalues()[i], rest * eigen.eigenvectors().col(i)));
  return modes;
}

RegulatorResult solve_regulator(const RegulatorProblem& p) {
  RegulatorResult result = find_fault(p);
  if (result.fault != RegulatorFault::none) return result;
  Matrix P = double_horizons(separate(p), p.B);
  double residual =
      P.allFinite() ? relative_residual(p, P) : std::numeric_limits<double>::infinity();
  if (P.allFinite()) refine(p, P, residual);
  if (!(residual <= std::sqrt(tuning::kRounding))) {
    result.fault = RegulatorFault::inaccurate;
    return result;
  }
  Regulator& regulator = result.regulator.emplace();
  regulator.K = gain(p, P);
  regulator.eigenvalues = sorted_eigenvalues(p.A - p.B * regulator.K);
  regulator.residual = residual;
  regulator.P = std::move(P);
  return result;
}

}  // namespace conddp
