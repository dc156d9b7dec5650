#include "ocp/linearization.hpp"

#include "ocp/transposed_product.hpp"

namespace conddp {
void KnotLinearization::apply(const Eigen::Ref<const Eigen::VectorXd>& z,
                              Eigen::Ref<Eigen::VectorXd> out) const {
  if (!semi_implicit) {
    out.noalias() = F * z;
    return;
  }
  const int nv = static_cast<int>(F.rows());
  auto dq = out.head(nv);
  auto dv = out.tail(nv);
  dv.noalias() = F * z;
  dq = z.head(nv) + dt * dv;
  for (std::size_t s = 0; s < curved.size(); ++s) {
    const int at = curved[s].dx, n = curved[s].n;
    dq.segment(at, n).noalias() = A[s].topLeftCorner(n, n) * z.segment(at, n);
    dq.segment(at, n).noalias() += dt * (H[s].topLeftCorner(n, n) * dv.segment(at, n));
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
    mu.segment(at, n) = lambda.segment(nv + at, n);
    mu.segment(at, n).noalias() += dt * (H[s].topLeftCorner(n, n).transpose() * lq.segment(at, n));
  }
  multiply_transposed(F, mu.data(), out.data());
  int flat = 0;
  for (std::size_t s = 0; s <= curved.size(); ++s) {
    const int end = s < curved.size() ? curved[s].dx : nv;
    out.segment(flat, end - flat) += lq.segment(flat, end - flat);
    if (s == curved.size()) break;
    const int at = curved[s].dx, n = curved[s].n;
    out.segment(at, n).noalias() += A[s].topLeftCorner(n, n).transpose() * lq.segment(at, n);
    flat = at + n;
  }
}

Eigen::MatrixXd KnotLinearization::dense_jacobian() const {
  const int nz = static_cast<int>(gradient.size());
  Eigen::MatrixXd jacobian(ndx, nz);
  for (int c = 0; c < nz; ++c) apply(Eigen::VectorXd::Unit(nz, c), jacobian.col(c));
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
    knot.hessian =
        KnotHessian(model.nz(), std::span(model.hessian_pattern()).first(model.lasting_entries()));
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

}  // namespace conddp
