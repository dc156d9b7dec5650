#include "ocp/knot/knot_second_derivatives.hpp"

#include <algorithm>

#include "ocp/knot/gauss_newton.hpp"
#include "ocp/terms/constraint.hpp"

namespace conddp {
namespace {

int row_count(const std::vector<RowBlock>& blocks) {
  int rows = 0;
  for (const RowBlock& block : blocks) rows += block.rows;
  return rows;
}

/// Copies numbers as duals with zero derivative.
void rest(const AlignedVector<Lane>& from, AlignedVector<Dual<Lane>>& to) {
  for (std::size_t i = 0; i < from.size(); ++i) to[i] = Dual<Lane>(from[i], Lane(0.0));
}

}  // namespace

std::unique_ptr<KnotSecondDerivatives> KnotSecondDerivatives::make(const KnotModel& model,
                                                                   KnotBatch<Lane>& at,
                                                                   KnotBatch<Dual<Lane>>& moving) {
  const bool integrates = std::ranges::any_of(model.costs(), &CostTerm::integrated);
  const bool has_curved_tail = model.step().tail() > 0 && !model.step().is_linear();
  if (integrates || model.has_units() || has_curved_tail) return nullptr;
  std::unique_ptr<KnotSecondDerivatives> made(new KnotSecondDerivatives(model, at, moving));
  return made->add_dynamics() && made->add_terms() ? std::move(made) : nullptr;
}

bool KnotSecondDerivatives::add_dynamics() {
  const IntegratorInfo& info = info_of(model_.integrator());
  if (info.kind == StepKind::none) return true;
  if (info.kind == StepKind::impulse || info.kind == StepKind::collocation) return false;
  if (model_.step().is_linear()) return true;
  system_ = model_.system().second_derivatives(*at_.work.step_.system, *moving_.work.step_.system);
  if (system_ == nullptr) return false;
  force_weights_.assign(system_->forces(), Lane(0.0));
  if (info.kind == StepKind::runge_kutta) stages_.emplace(model_.system(), info.rule, *system_);
  return true;
}

KnotSecondDerivatives::KnotSecondDerivatives(const KnotModel& model, KnotBatch<Lane>& at,
                                             KnotBatch<Dual<Lane>>& moving)
    : model_(model),
      at_(at),
      moving_(moving),
      nz_(model.nz()),
      system_weights_(model.system().rows(), Lane(0.0)),
      gradients_(nz_ * nz_, Lane(0.0)),
      step_(model.ndx(), D(0.0)) {
  const std::size_t blocks = StateManifold::kBlockSize * model.manifold().curved().size();
  state_blocks_.assign(blocks, D(0.0));
  step_blocks_.assign(blocks, D(0.0));
}

bool KnotSecondDerivatives::add_terms() {
  std::size_t rows = 0, entries = 0, formed = 0;
  for (const CostTerm& cost : model_.costs()) {
    Term term;
    term.cost = &cost;
    term.parameters = cost.parameters;
    if (!add_term(std::move(term), *cost.residual)) return false;
  }
  for (const ConstraintTerm& constraint : model_.constraints()) {
    Term term;
    term.constraint = &constraint;
    term.parameters = constraint.parameters;
    if (!add_term(std::move(term), *constraint.residual)) return false;
  }
  for (const Term& term : terms_) {
    rows = std::max<std::size_t>(rows, term.residual->size());
    entries = std::max<std::size_t>(entries, term.residual->jacobian_size());
    if (term.constraint) formed = std::max<std::size_t>(formed, term.constraint->jacobian_size());
  }
  moving_residual_.assign(rows, D(0.0));
  moving_value_.assign(rows, D(0.0));
  moving_jacobian_.assign(entries, D(0.0));
  formed_jacobian_.assign(formed, D(0.0));
  return true;
}

bool KnotSecondDerivatives::add_term(Term term, const Residual& residual) {
  find_curvature(term, residual);
  if (std::ranges::find(term.moves, true) == term.moves.end()) return true;
  const Reads reads = term.residual->reads();
  if (!moves_all_of(reads)) return false;
  reads_forces_ = reads_forces_ || reads == Reads::forces;
  term.weights.assign(std::max(row_count(*term.blocks), residual.size()), Lane(0.0));
  terms_.push_back(std::move(term));
  return true;
}

/// Sets the residual, the blocks and the curved columns of a term.
void KnotSecondDerivatives::find_curvature(Term& term, const Residual& residual) const {
  const ConstraintTerm* constraint = term.constraint;
  const bool norm = constraint && constraint->kind == ConstraintKind::norm;
  if (norm || (constraint && constraint->is_cone())) {
    const auto affine = [](const RowBlock& block) { return block.affine; };
    term.residual = &residual;
    term.blocks = &constraint->blocks;
    // A norm is curved even if its residual is affine.
    term.moves =
        curved_columns(*term.blocks, norm || !std::ranges::all_of(residual.blocks(), affine));
    return;
  }
  const LinearImage* image = residual.linear_image();
  term.residual = image ? image->of.get() : &residual;
  term.blocks = &term.residual->blocks();
  term.moves = curved_columns(*term.blocks, std::nullopt);
}

/// True if `moving` provides the derivatives of everything that a residual reads.
bool KnotSecondDerivatives::moves_all_of(Reads reads) const {
  return reads != Reads::everything && (reads != Reads::forces || system_ != nullptr);
}

/// Columns along which blocks are curved. `all` overrides this for every block; if unset, all
/// blocks that are not affine are curved.
std::vector<bool> KnotSecondDerivatives::curved_columns(const std::vector<RowBlock>& blocks,
                                                        std::optional<bool> all) const {
  std::vector<bool> moves(nz_, false);
  for (const RowBlock& block : blocks) {
    if (!all.value_or(!block.affine)) continue;
    for (const int column : block.columns)
      if (!std::ranges::binary_search(block.affine_columns, column)) moves[column] = true;
  }
  // The position of a pose moves along axes that turn with its orientation.
  for (const auto& segment : model_.manifold().curved()) {
    const auto begin = moves.begin() + segment.dx, end = begin + segment.n;
    if (std::find(begin, end, true) != end) std::fill(begin, end, true);
  }
  return moves;
}

void KnotSecondDerivatives::weigh_cost(Term& term) {
  const CostTerm& cost = *term.cost;
  KnotWorkspace<Lane>& work = at_.work;
  const KnotInput<Lane> in = at_.input();
  const ResidualInput<Lane> input{in.x, in.u, in.parameters + cost.parameters, *work.step_.system};
  const int rows = cost.residual->size();
  Lane* slope = work.activation_gradient_.data();
  Lane unused;
  cost.residual->evaluate(input, work.residual_.data());
  cost.activation.differentiate(work.residual_.data(), rows, slope,
                                work.activation_diagonal_.data(), unused);
  const Lane scale = in.cost_scale * in.parameters[cost.weight];
  if (const LinearImage* image = cost.residual->linear_image()) {
    const int k = image->of->size();
    std::fill(term.weights.begin(), term.weights.end(), Lane(0.0));
    for (int r = 0; r < rows; ++r)
      for (int i = 0; i < k; ++i) term.weights[i] += slope[r] * scale * image->A[r * k + i];
    return;
  }
  for (int r = 0; r < rows; ++r) term.weights[r] = scale * slope[r];
}

void KnotSecondDerivatives::weigh_constraint(Term& term) {
  const ConstraintTerm& constraint = *term.constraint;
  KnotWorkspace<Lane>& work = at_.work;
  const KnotInput<Lane> in = at_.input();
  const ResidualInput<Lane> input{in.x, in.u, in.parameters + constraint.parameters,
                                  *work.step_.system};
  std::fill(term.weights.begin(), term.weights.end(), Lane(0.0));
  constraint.residual->evaluate(input, work.residual_.data());
  form_value(constraint, work.residual_.data(), work.constraint.data() + constraint.row);
  const Lane cost = work.cost, augmentation = work.augmentation;
  const bool counts = model_.add_penalty<Lane>(constraint, in, work, nullptr).has_value();
  work.cost = cost;
  work.augmentation = augmentation;
  if (!counts) return;
  const LinearImage* image = constraint.residual->linear_image();
  if (image == nullptr || image->of.get() != term.residual) {
    std::copy_n(work.weight_.begin(), constraint.rows, term.weights.begin());
    return;
  }
  const int k = image->of->size();
  for (int r = 0; r < constraint.rows; ++r)
    for (int i = 0; i < k; ++i) term.weights[i] += work.weight_[r] * image->A[r * k + i];
}

void KnotSecondDerivatives::weigh_terms() {
  for (Term& term : terms_) {
    term.cost ? weigh_cost(term) : weigh_constraint(term);
    // Rows with a constant Jacobian do not contribute to the Hessian.
    int row = 0;
    for (const RowBlock& block : *term.blocks) {
      if (block.affine) std::fill_n(term.weights.begin() + row, block.rows, Lane(0.0));
      row += block.rows;
    }
    term.active = !all_zero(term.weights.data(), row);
  }
}

ResidualInput<Dual<Lane>> KnotSecondDerivatives::moving_input(const Term& term) {
  return {moving_.x.data(), moving_.u.data(), moving_.parameters.data() + term.parameters,
          *moving_.work.step_.system};
}

void KnotSecondDerivatives::weigh_forces() {
  if (!reads_forces_) return;
  for (std::size_t row = 0; row < force_weights_.size(); ++row) {
    Lane sum(0.0);
    system_->move_force(static_cast<int>(row));
    for (const Term& term : terms_)
      if (term.active && term.residual->reads() == Reads::forces) add_weighted_slope(term, sum);
    force_weights_[row] = sum;
  }
}

/// Adds the derivatives of a term's rows along the moving force, times their weights.
void KnotSecondDerivatives::add_weighted_slope(const Term& term, Lane& sum) {
  term.residual->evaluate(moving_input(term), moving_residual_.data());
  const D* value = moving_residual_.data();
  if (term.blocks != &term.residual->blocks()) {
    form_value(*term.constraint, moving_residual_.data(), moving_value_.data());
    value = moving_value_.data();
  }
  const int rows = row_count(*term.blocks);
  for (int i = 0; i < rows; ++i) sum += term.weights[i] * value[i].d;
}

void KnotSecondDerivatives::weigh_system(const Lane* costates) {
  if (stages_) return add_later_stages(costates);
  if (!model_.semi_implicit()) {
    std::copy_n(costates, system_weights_.size(), system_weights_.begin());
    return;
  }
  // v⁺ = v + dt a.
  pull_back_to_velocity(model_, at_.work, at_.dt, costates, system_weights_.data());
  for (Lane& weight : system_weights_) weight = at_.dt * weight;
}

/// Restores the system's data to the knot's own state afterwards.
void KnotSecondDerivatives::add_later_stages(const Lane* costates) {
  SystemData<Lane>& data = *at_.work.step_.system;
  stages_->add_later_stages({at_.u.data(), at_.dt, at_.work.step_.integrator, data}, costates,
                            system_weights_.data(), gradients_.data());
  model_.system().differentiate(at_.x.data(), at_.u.data(), data);
}

void KnotSecondDerivatives::differentiate_terms(int d, Lane* column) {
  for (const Term& term : terms_) {
    if (!term.active || !term.moves[d]) continue;
    const D* jacobian = moving_jacobian(term);
    const Lane* weight = term.weights.data();
    for (const RowBlock& block : *term.blocks) {
      const auto is_affine = [&block](int c) {
        return std::ranges::binary_search(block.affine_columns, c);
      };
      const bool moves = !is_affine(d);
      for (const int c : block.columns) {
        Lane sum(0.0);
        for (int i = 0; moves && i < block.rows; ++i) sum += jacobian[i].d * weight[i];
        column[c] += sum;
        if (is_affine(c)) gradients_[d + c * nz_] += sum;
        jacobian += block.rows;
      }
      weight += block.rows;
    }
  }
}

const Dual<Lane>* KnotSecondDerivatives::moving_jacobian(const Term& term) {
  term.residual->differentiate(moving_input(term), moving_residual_.data(),
                               moving_jacobian_.data());
  if (term.blocks == &term.residual->blocks()) return moving_jacobian_.data();
  const D norm = form_value(*term.constraint, moving_residual_.data(), moving_value_.data());
  form_jacobian(*term.constraint, moving_residual_.data(), norm, moving_jacobian_.data(),
                formed_jacobian_.data());
  return formed_jacobian_.data();
}

void KnotSecondDerivatives::add_curved_steps(const Lane* costates) {
  int offset = 0;
  for (const auto& s : model_.manifold().curved()) {
    StepCurvature curvature;
    bend_step(s, offset, costates, curvature);
    for (int d = 0; d < nz_; ++d) add_curved_step(s, curvature, d);
    offset += StateManifold::kBlockSize;
  }
}

void KnotSecondDerivatives::bend_step(const StateManifold::Segment& s, int offset,
                                      const Lane* costates, StepCurvature& out) {
  const int n = model_.system().nv();
  for (int j = 0; j < s.n; ++j) {
    for (int i = 0; i < n; ++i) step_[i] = D(at_.work.step_.integrator.tangent[i], Lane(0.0));
    step_[s.dx + j].d = Lane(1.0);
    model_.manifold().integrate_jacobians(step_.data(), state_blocks_.data(), step_blocks_.data());
    for (int i = 0; i < s.n; ++i) {
      Lane state(0.0), step(0.0);
      for (int k = 0; k < s.n; ++k) {
        state += state_blocks_[offset + k * s.n + i].d * costates[s.dx + k];
        step += step_blocks_[offset + k * s.n + i].d * costates[s.dx + k];
      }
      out.of_state[j][i] = state;
      out.of_velocity[j][i] = at_.dt * step;
    }
  }
}

/// Adds to column d of `gradients_`.
void KnotSecondDerivatives::add_curved_step(const StateManifold::Segment& s,
                                            const StepCurvature& curvature, int d) {
  const int n = model_.system().nv();
  const AlignedVector<Lane>& F = at_.work.F();
  Lane* column = &gradients_[d * nz_];
  Lane pulled[6];
  std::fill_n(pulled, s.n, Lane(0.0));
  for (int j = 0; j < s.n; ++j) {
    const Lane moved = at_.dt * F[d * n + s.dx + j];
    for (int i = 0; i < s.n; ++i) {
      column[s.dx + i] += curvature.of_state[j][i] * moved;
      pulled[i] += curvature.of_velocity[j][i] * moved;
    }
  }
  for (int c = 0; c < nz_; ++c)
    for (int i = 0; i < s.n; ++i) column[c] += F[c * n + s.dx + i] * pulled[i];
}

const AlignedVector<Lane>& KnotSecondDerivatives::compute(const Lane* costates) {
  rest(at_.x, moving_.x);
  rest(at_.u, moving_.u);
  rest(at_.parameters, moving_.parameters);
  model_.differentiate(at_.input(), at_.work, true);
  std::fill(gradients_.begin(), gradients_.end(), Lane(0.0));
  if (system_) weigh_system(costates);
  weigh_terms();
  if (system_) start_system();
  differentiate_gradients();
  if (system_) system_->finish(gradients_.data());
  if (model_.semi_implicit()) add_curved_steps(costates);
  symmetrize();
  add_gauss_newton();
  return gradients_;
}

/// Starts the system with the weights of its rows and of the forces that residuals read.
void KnotSecondDerivatives::start_system() {
  system_->start(moving_.x.data(), moving_.u.data());
  weigh_forces();
  system_->weigh(system_weights_.data(), force_weights_.data());
}

/// Differentiates along the columns with a nonlinear term or nonlinear dynamics.
void KnotSecondDerivatives::differentiate_gradients() {
  const bool moves = system_ && !system_->at_once();
  for (int d = 0; d < nz_; ++d) {
    const bool bends = std::any_of(terms_.begin(), terms_.end(),
                                   [d](const Term& term) { return term.active && term.moves[d]; });
    if (bends || (moves && d < model_.ndx())) differentiate_along(d, bends);
  }
}

/// The derivative of the gradient along the manifold differs from the Hessian only by an
/// antisymmetric (Lie bracket) term.
void KnotSecondDerivatives::symmetrize() {
  for (int c = 0; c < nz_; ++c)
    for (int r = 0; r < c; ++r) {
      Lane &a = gradients_[c * nz_ + r], &b = gradients_[r * nz_ + c];
      a = b = 0.5 * (a + b);
    }
}

/// Adds the derivative of the gradient along column d of z, including that of the terms if `bends`.
void KnotSecondDerivatives::differentiate_along(int d, bool bends) {
  const int n = model_.ndx();
  rest(at_.x, moving_.x);
  if (d < n) {
    for (D& step : step_) step = D(0.0);
    step_[d].d = Lane(1.0);
    model_.manifold().integrate(moving_.x.data(), step_.data(), moving_.x.data());
  } else {
    moving_.u[d - n].d = Lane(1.0);
  }
  if (system_)
    system_->move(moving_.x.data(), d, gradients_.data());
  else
    model_.system().update_kinematics(moving_.x.data(), *moving_.work.step_.system);
  if (bends) differentiate_terms(d, &gradients_[d * nz_]);
  if (d >= n) moving_.u[d - n].d = Lane(0.0);
}

void KnotSecondDerivatives::add_gauss_newton() {
  const auto& pattern = model_.hessian_pattern();
  for (std::size_t i = 0; i < pattern.size(); ++i) {
    const auto [r, c] = pattern[i];
    gradients_[c * nz_ + r] += at_.work.hessian[i];
    if (r != c) gradients_[r * nz_ + c] += at_.work.hessian[i];
  }
}

}  // namespace conddp
