#include "solvers/riccati/parametric_segment.hpp"

#include "solvers/linalg/curved_blocks.hpp"
#include "solvers/linalg/lane_gemm.hpp"

namespace conddp {
namespace {

using StateBlock = Eigen::Matrix<double, 6, 6, Eigen::RowMajor>;

void transform(const StateBlock& B, const StateManifold::Segment& segment, const LaneBlock& X) {
  transform_columns({B.data(), segment.n, 6}, X.data + segment.dx * X.stride, X.stride, X.rows);
}

}  // namespace

ParametricSegment::ParametricSegment(const ShootingProblem& problem, int index, int first, int last,
                                     int parts)
    : index_(index),
      first_(first),
      last_(last),
      ndx_(problem.ndx()),
      row_(parameter_row(problem)),
      stage_(problem, true),
      end_(ndx_),
      Lt_(last - first + 1, LaneMatrix(ndx_, ndx_)),
      S_(ndx_, ndx_),
      Zt_(ndx_, ndx_ + largest_nu(problem)),
      pulled_(ndx_, ndx_),
      columns_(ndx_, ndx_),
      stacked_(parametric_rows(problem), largest_nu(problem)),
      s_(ndx_) {
  for (int k = first; k < last; ++k) Kt_.emplace_back(ndx_, problem.nu(k));
  Lt_.back().view().setIdentity();
  for (int part = 0; part < parts; ++part)
    scratch_.push_back({Eigen::VectorXd(ndx_), Eigen::VectorXd(ndx_ + largest_nu(problem)),
                        Eigen::VectorXd(ndx_)});
}

bool ParametricSegment::sweep(const SweptHorizon& horizon, StageSolver& stages, Feedback& feedback,
                              std::vector<ValueFunction>& values,
                              std::vector<Eigen::MatrixXd>& Quu) {
  s_.setZero();
  S_.flat().setZero();
  for (int k = last_ - 1; k >= first_; --k) {
    stage_.propagate(horizon, k, k + 1 == last_ ? end_ : values[k + 1]);
    Quu[k] = stage_.q().Quu();
    pull_parameters(horizon, k);
    if (!solve(horizon, k, stages, feedback)) return false;
    if (!stage_.form_value(values[k], feedback.k[k], true)) return false;
    form_parameters(k, feedback.k[k]);
  }
  return true;
}

/// Pulls Lᵀ back through the gap and the dynamics, with the structure of ValuePropagation.
void ParametricSegment::pull_parameters(const SweptHorizon& horizon, int k) {
  const KnotLinearization& knot = horizon.linearization.knots[k];
  const LaneBlock L = pulled_.block();
  pulled_.flat() = Lt_[k + 1 - first_].flat();
  horizon.gaps[k].pull(L, s_);
  Zt_.resize(ndx_, ndx_ + knot.nu());
  if (!knot.semi_implicit) return multiply(Store::set, Zt_.block(), L, Factor::of_eigen(knot.F));
  // L_v + dt L_q H is multiplied by F, and L_q A stays in the columns of δq.
  const int nv = static_cast<int>(knot.F.rows());
  columns_.resize(ndx_, nv);
  columns_.view() = knot.dt * L.view().leftCols(nv);
  for (std::size_t i = 0; i < knot.curved.size(); ++i) {
    transform(knot.H[i], knot.curved[i], columns_.block());
    transform(knot.A[i], knot.curved[i], L);
  }
  columns_.view() += L.view().rightCols(nv);
  multiply(Store::set, Zt_.block(), columns_.block(), Factor::of_eigen(knot.F));
  Zt_.view().leftCols(nv) += L.view().leftCols(nv);
}

bool ParametricSegment::solve(const SweptHorizon& horizon, int k, StageSolver& stages,
                              Feedback& feedback) {
  const int nu = stage_.q().nu();
  stacked_.resize(row_ + ndx_, nu);
  auto stacked = stacked_.view();
  stacked.topRows(ndx_) = stage_.q().Qxu();
  stacked.middleRows(ndx_, row_ - ndx_).setZero();
  stacked.bottomRows(ndx_) = Zt_.view().rightCols(nu);
  if (!stage_.solve(horizon, k, stacked, index_, stages, feedback)) return false;
  if (nu > 0) Kt_[k - first_] = stage_.Kt().view().middleRows(row_, ndx_);
  return true;
}

void ParametricSegment::form_parameters(int k, const Eigen::VectorXd& feedforward) {
  const int nu = stage_.q().nu();
  LaneMatrix& L = Lt_[k - first_];
  const LaneBlock B = Zt_.block(ndx_, ndx_, nu);
  L.view() = Zt_.view().leftCols(ndx_);
  if (nu == 0) return;
  LaneMatrix& Kt = stage_.Kt();
  multiply(Store::add, L.block(), B, Factor::transposed(Kt));
  multiply_lower(Store::add, S_.block(), B, {Kt.data() + row_, Kt.stride(), 1});
  s_.noalias() += B.view() * feedforward;
}

void ParametricSegment::apply(int part, const SweptHorizon& horizon, const Eigen::VectorXd& theta,
                              ActiveSet& active_set, Feedback& feedback,
                              std::vector<ValueFunction>& values) {
  auto& [costate, gradients, product] = scratch_[part];
  const int parts = static_cast<int>(scratch_.size()), knots = last_ - first_;
  const int end = first_ + knots * (part + 1) / parts;
  for (int k = first_ + knots * part / parts; k < end; ++k) {
    values[k].Vx.noalias() += Lt_[k - first_].view().transpose() * theta;
    const int nu = static_cast<int>(feedback.k[k].size());
    feedback.k[k].noalias() += Kt_[k - first_].transpose() * theta;
    if (!active_set.holds_any(k)) continue;
    costate.noalias() = Lt_[k + 1 - first_].view().transpose() * theta;
    horizon.gaps[k].pull(costate);
    auto gradient = gradients.head(ndx_ + nu);
    horizon.linearization.knots[k].apply_transpose(costate, gradient, product);
    active_set.change_gradient(k, gradient.tail(nu));
  }
}

}  // namespace conddp
