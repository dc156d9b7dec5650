#include "ocp/evaluation/linearization.hpp"

#include "ocp/evaluation/matrix_vector.hpp"
#include "spatial/lane.hpp"

namespace conddp {
namespace {

using StateBlock = Eigen::Matrix<double, 6, 6, Eigen::RowMajor>;
template <int n>
using Part = Eigen::Map<Eigen::Matrix<double, n, 1>>;
template <int n>
using ConstPart = Eigen::Map<const Eigen::Matrix<double, n, 1>>;

/// δq ← A δq₀ + dt H δv on a curved segment.
template <int n>
void step_curved(const StateBlock& A, const StateBlock& H, double dt, const double* dq0,
                 const double* dv, double* dq) {
  Part<n> sum(dq);
  sum.noalias() = H.topLeftCorner<n, n>() * ConstPart<n>(dv);
  sum *= dt;
  sum.noalias() += A.topLeftCorner<n, n>() * ConstPart<n>(dq0);
}

/// The transpose of step_curved: μ ← λ_v + dt Hᵀ λ_q and, later, out += Aᵀ λ_q.
template <int n>
void pull_step(const StateBlock& H, double dt, const double* lq, const double* lv, double* mu) {
  Part<n> sum(mu);
  sum.noalias() = H.topLeftCorner<n, n>().transpose() * ConstPart<n>(lq);
  sum = ConstPart<n>(lv) + dt * sum;
}
template <int n>
void add_pulled(const StateBlock& A, const double* lq, double* out) {
  Part<n>(out).noalias() += A.topLeftCorner<n, n>().transpose() * ConstPart<n>(lq);
}

/// Rows of ∂q⁺/∂z of a curved segment, from those of F.
template <int n>
void step_rows(const StateBlock& H, double dt, const double* F, Eigen::Index stride, double* out,
               Eigen::Index out_stride, Eigen::Index columns) {
  for (Eigen::Index c = 0; c < columns; ++c) {
    Part<n> column(out + c * out_stride);
    column.noalias() = H.topLeftCorner<n, n>() * ConstPart<n>(F + c * stride);
    column *= dt;
  }
}

}  // namespace

KnotHessian::KnotHessian(int nz, std::span<const std::pair<int, int>> lasting)
    : matrix_(Eigen::MatrixXd::Zero(nz, nz)), fill_(HessianFill::lasting) {
  const int blocks = (nz + kLaneWidth - 1) / kLaneWidth;  // per column
  std::vector<bool> filled(static_cast<std::size_t>(nz) * blocks);
  for (const auto& [row, column] : lasting) filled[column * blocks + row / kLaneWidth] = true;
  for (int column = 0; column < nz; ++column)
    for (int block = 0; block < blocks; ++block)
      if (filled[column * blocks + block]) lasting_lanes_.push_back({block * kLaneWidth, column});
}

void KnotLinearization::apply(const Eigen::Ref<const Eigen::VectorXd>& z,
                              Eigen::Ref<Eigen::VectorXd> out) const {
  if (!semi_implicit) {
    multiply(F, z.data(), out.data());
    return;
  }
  const int nv = static_cast<int>(F.rows());
  auto dq = out.head(nv);
  auto dv = out.tail(nv);
  multiply(F, z.data(), dv.data());
  dq = z.head(nv) + dt * dv;
  for (std::size_t s = 0; s < curved.size(); ++s) {
    const int at = curved[s].dx, n = curved[s].n;
    (n == 6 ? step_curved<6> : step_curved<3>)(A[s], H[s], dt, z.data() + at, dv.data() + at,
                                               dq.data() + at);
  }
}

void KnotLinearization::apply_transpose(const Eigen::Ref<const Eigen::VectorXd>& lambda,
                                        Eigen::Ref<Eigen::VectorXd> out,
                                        Eigen::Ref<Eigen::VectorXd> scratch) const {
  if (!semi_implicit) return multiply_transposed(F, lambda.data(), out.data());
  const int nv = static_cast<int>(F.rows());
  const auto lq = lambda.head(nv);
  auto mu = scratch.head(nv);
  mu = lambda.tail(nv) + dt * lq;
  for (std::size_t s = 0; s < curved.size(); ++s) {
    const int at = curved[s].dx, n = curved[s].n;
    (n == 6 ? pull_step<6> : pull_step<3>)(H[s], dt, lq.data() + at, lambda.data() + nv + at,
                                           mu.data() + at);
  }
  multiply_transposed(F, mu.data(), out.data());
  int flat = 0;
  for (std::size_t s = 0; s <= curved.size(); ++s) {
    const int end = s < curved.size() ? curved[s].dx : nv;
    out.segment(flat, end - flat) += lq.segment(flat, end - flat);
    if (s == curved.size()) break;
    const int at = curved[s].dx, n = curved[s].n;
    (n == 6 ? add_pulled<6> : add_pulled<3>)(A[s], lq.data() + at, out.data() + at);
    flat = at + n;
  }
}

Eigen::MatrixXd KnotLinearization::dense_jacobian() const {
  if (!semi_implicit) return F;
  const Eigen::Index nv = F.rows();
  Eigen::MatrixXd jacobian(ndx, F.cols());
  jacobian.bottomRows(nv) = F;
  jacobian.topRows(nv) = dt * F;
  jacobian.topLeftCorner(nv, nv).diagonal().array() += 1;
  for (std::size_t s = 0; s < curved.size(); ++s) {
    const int at = curved[s].dx, n = curved[s].n;
    (n == 6 ? step_rows<6> : step_rows<3>)(H[s], dt, F.data() + at, nv, jacobian.data() + at, ndx,
                                           F.cols());
    jacobian.block(at, at, n, n) += A[s].topLeftCorner(n, n);
  }
  return jacobian;
}

Linearization::Linearization(const ShootingProblem& problem)
    : knots(problem.knots() + 1),
      gap(Eigen::MatrixXd::Zero(problem.ndx(), problem.knots())),
      cost(Eigen::VectorXd::Zero(problem.knots() + 1)),
      augmentation(cost),
      constraint(Eigen::VectorXd::Zero(problem.constraint_rows())) {
  for (int k = 0; k <= problem.knots(); ++k) {
    const KnotModel& model = *problem.knot(k).model;
    KnotLinearization& knot = knots[k];
    knot.ndx = model.ndx();
    knot.gradient = Eigen::VectorXd::Zero(model.nz());
    // Copying costs less than evaluating the pattern.
    knot.hessian =
        k > 0 && problem.knot(k - 1).model == &model
            ? knots[k - 1].hessian
            : KnotHessian(model.nz(),
                          std::span(model.hessian_pattern()).first(model.lasting_entries()));
    knot.F = Eigen::MatrixXd::Zero(model.jacobian_rows(), model.nz());
    knot.C = Eigen::MatrixXd::Zero(model.constraint_rows(), model.nz());
    knot.dt = problem.knot(k).dt;
    knot.semi_implicit = model.jacobian_rows() > 0 && model.semi_implicit();
    if (!knot.semi_implicit) continue;
    knot.curved = model.manifold().curved();
    knot.A.resize(knot.curved.size());
    knot.H.resize(knot.curved.size());
  }
}

void Linearization::exchange(const ShootingProblem& own, Linearization& other,
                             const ShootingProblem& others) {
  std::size_t next = 0;
  for (std::size_t k = 0; k < knots.size(); ++k) {
    std::size_t at = next;
    const KnotModel* model = own.knot(static_cast<int>(k)).model;
    while (at < other.knots.size() && others.knot(static_cast<int>(at)).model != model) ++at;
    if (at == other.knots.size()) continue;
    std::swap(knots[k], other.knots[at]);
    next = at + 1;
  }
}

}  // namespace conddp
