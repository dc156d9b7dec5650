#include <algorithm>
#include <utility>

#include "ocp/knot/gauss_newton.hpp"
#include "ocp/knot/knot_model.hpp"

namespace conddp {

/// Adds the integrated costs of a knot, stage by stage, to cost, gradient and Hessian in a
/// workspace. The sums are Σ b_i ℓ(z_i), Σ b_i Z_iᵀ ∇ℓ and Σ b_i Z_iᵀ ∇²ℓ Z_i, with z_i = (x_i,
/// u_i) and Z_i = ∂z_i/∂z. Here ∇²ℓ is the Gauss-Newton Hessian.
template <class S>
class StageCosts : public StageVisitor<S> {
 public:
  StageCosts(const KnotModel& model, const KnotInput<S>& in, KnotWorkspace<S>& work,
             const KnotModel::Wanted& wanted)
      : model_(model),
        step_(model.step()),
        in_(in),
        work_(work),
        derivatives_(wanted.derivatives),
        hessian_(wanted.hessian) {}

  /// Visitor for the integrator; null if no cost is integrated.
  StageVisitor<S>* visitor() { return model_.stage_index_.empty() ? nullptr : this; }
  void visit(const StageView<S>& stage) override;
  /// Visits the stages of a collocation step, which the integrator does not visit.
  void visit_collocation();

 private:
  template <class F>
  void for_each_cost(F evaluate);
  KnotInput<S> input_at(const StageView<S>& stage);
  void differentiate(const CostPoint<S>& at, const StageView<S>& stage);
  void fill_derivative(const StageView<S>& stage);
  void pull_back_hessian();

  const KnotModel& model_;
  const Step& step_;
  const KnotInput<S>& in_;
  KnotWorkspace<S>& work_;
  bool derivatives_, hessian_;
};

template <class S>
void StageCosts<S>::visit(const StageView<S>& stage) {
  if (model_.quadrature_[stage.stage].weight == 0) return;
  const KnotInput<S> in = input_at(stage);
  const CostPoint<S> at{in, stage.data, stage.stage};
  if (derivatives_) return differentiate(at, stage);
  for_each_cost([&](std::size_t t) { model_.evaluate_cost(t, at, work_); });
}

/// Sums each integrated cost over the stages.
template <class S>
template <class F>
void StageCosts<S>::for_each_cost(F evaluate) {
  for (std::size_t t = 0; t < model_.costs_.size(); ++t) {
    if (!model_.costs_[t].integrated) continue;
    const S before = work_.term_costs[t];
    evaluate(t);
    work_.term_costs[t] += before;
  }
}

template <class S>
void StageCosts<S>::visit_collocation() {
  const CollocationSystem* system = model_.system().as_collocation();
  if (system == nullptr || visitor() == nullptr) return;
  SystemData<S>& begin = *work_.step_.system;
  auto& later = static_cast<CollocationSystem::Later<S>&>(*begin.later);
  const S* w = in_.u;
  const S* u = step_.first_control(in_.x, in_.u);
  const S dt = step_.time_step(in_.dt, in_.x);
  const bool linear = step_.last_control(w) != nullptr;
  if (derivatives_) {
    std::fill(later.X.begin(), later.X.end(), S(0.0));
    for (int c = 0; c < system->ndx(); ++c) later.X[c * system->ndx() + c] = S(1.0);
  }
  visit({0, 0.0, in_.x, u, later.X.data(), begin});
  for (int i = 1; i <= system->later_stages(); ++i) {
    const double passed = system->time(i);
    if (linear)
      for (int c = 0; c < system->actuators(); ++c) later.u[c] = u[c] + S(passed) * (w[c] - u[c]);
    const S* at = linear ? later.u.data() : u;
    system->stage(i, in_.x, w, dt, begin, later.x.data());
    if (derivatives_) {
      system->differentiate_stage(i, in_.x, w, dt, begin, step_.duration().has_value(),
                                  later.X.data());
      system->inside()->differentiate(later.x.data(), at, *later.inside);
    } else {
      system->inside()->evaluate(later.x.data(), at, *later.inside);
    }
    visit({i, passed, later.x.data(), at, later.X.data(), *later.inside});
  }
}

/// Input of the knot with the state of a stage, its cost scale times the stage's weight.
template <class S>
KnotInput<S> StageCosts<S>::input_at(const StageView<S>& stage) {
  step_.stage_state(stage, in_.x, work_.stage_x_.data());
  KnotInput<S> in = in_;
  in.x = work_.stage_x_.data();
  in.cost_scale = in_.cost_scale * S(model_.quadrature_[stage.stage].weight);
  return in;
}

template <class S>
void StageCosts<S>::differentiate(const CostPoint<S>& at, const StageView<S>& stage) {
  // Swap buffers so that gradient and Hessian are written for the stage instead of the knot.
  std::swap(work_.gradient, work_.stage_gradient_);
  std::swap(work_.hessian, work_.stage_hessian_);
  std::fill(work_.gradient.begin(), work_.gradient.end(), S(0.0));
  if (hessian_) std::fill(work_.hessian.begin(), work_.hessian.end(), S(0.0));
  for_each_cost([&](std::size_t t) { model_.differentiate_cost(t, at, work_, hessian_); });
  std::swap(work_.gradient, work_.stage_gradient_);
  std::swap(work_.hessian, work_.stage_hessian_);
  fill_derivative(stage);
  const std::vector<int>& rows = model_.stage_columns_;
  const S* Z = work_.stage_Z_.data();
  for (int c = 0; c < model_.nz(); ++c)
    for (const int row : rows) work_.gradient[c] += *Z++ * work_.stage_gradient_[row];
  if (hessian_) pull_back_hessian();
}

/// Fills the rows of Z that the costs use, by columns.
template <class S>
void StageCosts<S>::fill_derivative(const StageView<S>& stage) {
  S* Z = work_.stage_Z_.data();
  for (int c = 0; c < model_.nz(); ++c)
    for (const int row : model_.stage_columns_)
      *Z++ = step_.stage_derivative(stage, row, c, in_.dt, work_.step_);
}

template <class S>
void StageCosts<S>::pull_back_hessian() {
  const int rows = static_cast<int>(model_.stage_columns_.size()), nz = model_.nz();
  S* dense = work_.stage_dense_.data();
  std::fill(work_.stage_dense_.begin(), work_.stage_dense_.end(), S(0.0));
  for (std::size_t i = 0; i < model_.stage_pattern_.size(); ++i) {
    const int a = model_.stage_places_[model_.stage_pattern_[i].first];
    const int b = model_.stage_places_[model_.stage_pattern_[i].second];
    dense[a * rows + b] = dense[b * rows + a] = work_.stage_hessian_[i];
  }
  const S* Z = work_.stage_Z_.data();
  S* product = work_.stage_HZ_.data();
  for (int c = 0; c < nz; ++c, Z += rows)
    for (int r = 0; r < rows; ++r) *product++ = dot(rows, dense + r * rows, Z);
  add_products(rows, nz, work_.stage_Z_.data(), work_.stage_HZ_.data(), model_.stage_index_.data(),
               work_.hessian.data());
}

template <class S>
void KnotModel::take_step(const KnotInput<S>& in, KnotWorkspace<S>& work,
                          const Wanted& wanted) const {
  StageCosts<S> costs(*this, in, work, wanted);
  step_.take({in.x, in.u, in.parameters, in.dt}, work.step_, wanted.derivatives, costs.visitor());
  costs.visit_collocation();
  if (!wanted.derivatives) return;
  for (std::size_t t = 0; t < costs_.size(); ++t)
    if (costs_[t].integrated) add_growth(costs_[t].grows_with, work.term_costs[t], in.x, work);
}

#define CONDDP_INSTANTIATE(S) \
  template void KnotModel::take_step(const KnotInput<S>&, KnotWorkspace<S>&, const Wanted&) const;
CONDDP_FOR_EACH_SCALAR(CONDDP_INSTANTIATE)
#undef CONDDP_INSTANTIATE

}  // namespace conddp
