#include "ocp/knot/knot_model.hpp"

#include <algorithm>
#include <stdexcept>

#include "ocp/knot/gauss_newton.hpp"

namespace conddp {
KnotModel::KnotModel(std::shared_ptr<const System> system, Integrator integrator,
                     bool control_memory, int held_memory)
    : system_(std::move(system)), manifold_(system_->manifold()), integrator_(integrator) {
  const bool discrete = system_->kind() == SystemKind::discrete;
  if (integrator != Integrator::none && discrete != (integrator == Integrator::discrete))
    throw std::invalid_argument("a discrete system needs the discrete integrator, and only it");
  if (discrete && !manifold_.curved().empty())
    throw std::invalid_argument("a discrete system needs a flat state space");
  if (integrator == Integrator::semi_implicit_euler && system_->kind() != SystemKind::second_order)
    throw std::invalid_argument("semi-implicit Euler needs a second-order system");
  const bool impulse = system_->kind() == SystemKind::impulse;
  if (integrator != Integrator::none && impulse != (integrator == Integrator::impulse))
    throw std::invalid_argument("an impulse needs the integrator of impulses, and only it");
  if (impulse && control_memory)
    throw std::invalid_argument("an impulse has no control to remember");
  const auto* collocation = system_->as_collocation();
  if (integrator != Integrator::none &&
      lobatto_rule(integrator) != (collocation ? std::optional(collocation->rule()) : std::nullopt))
    throw std::invalid_argument(
        "a collocation system needs the integrator of its rule, and only it");
  if (control_memory && held_memory > 0)
    throw std::invalid_argument("a memory is of the control or held, not both");
  held_ = held_memory > 0;
  memory_ = held_ ? held_memory : control_memory ? system_->actuators() : 0;
  if (memory_ > 0) manifold_.append(StateManifold::Part::flat, memory_);
  lower_.assign(nu(), -std::numeric_limits<double>::infinity());
  upper_.assign(nu(), std::numeric_limits<double>::infinity());
}

void KnotModel::check_fit(const std::string& what, const Residual& residual) const {
  if (residual.needs_control() && nu() == 0)
    throw std::invalid_argument(what + " needs a control, which this node has not");
  for (const RowBlock& block : residual.blocks())
    for (const int column : block.columns)
      if (column < 0 || column >= nz())
        throw std::invalid_argument(what + " depends on column " + std::to_string(column) +
                                    ", and a knot has " + std::to_string(nz()));
}

int KnotModel::add_cost(std::string name, std::shared_ptr<const Residual> residual,
                        Activation activation) {
  check_fit("cost " + name, *residual);
  CostTerm& term = costs_.emplace_back();
  term.name = std::move(name);
  term.parameters = parameter_count_;
  term.weight = parameter_count_ + residual->parameter_count();
  parameter_count_ = term.weight + 1;
  term.residual = std::move(residual);
  term.activation = std::move(activation);
  if (term.is_barrier()) {
    term.row = constraint_rows_;
    term.jacobian = add_rows(term.residual->blocks());
  }
  index_hessian();
  return term.parameters;
}

void KnotModel::index_hessian() {
  const int n = nz();
  std::vector<int> entry_at(n * n, -1);
  pattern_.clear();
  pattern_index_.resize(costs_.size());
  constraint_pattern_index_.resize(constraints_.size());
  const auto index = [&](const std::vector<RowBlock>& blocks, std::vector<int>& pairs) {
    pairs.clear();
    for (const RowBlock& block : blocks)
      for (std::size_t a = 0; a < block.columns.size(); ++a)
        for (std::size_t b = 0; b <= a; ++b) {
          int& entry = entry_at[block.columns[b] * n + block.columns[a]];
          if (entry < 0) {
            entry = static_cast<int>(pattern_.size());
            pattern_.emplace_back(block.columns[a], block.columns[b]);
          }
          pairs.push_back(entry);
        }
  };
  for (const bool rests : {false, true}) {
    for (std::size_t t = 0; t < costs_.size(); ++t) {
      if (costs_[t].is_barrier() != rests) continue;  // inside its bounds a barrier is nothing
      std::vector<RowBlock> blocks = costs_[t].residual->blocks();
      if (costs_[t].activation.kind == ActivationKind::smooth_l2)
        blocks.push_back({1, column_range(0, n)});
      index(blocks, pattern_index_[t]);
    }
    if (!rests) lasting_entries_ = static_cast<int>(pattern_.size());
  }
  for (std::size_t t = 0; t < constraints_.size(); ++t)
    index(constraints_[t].blocks, constraint_pattern_index_[t]);
}

void KnotModel::set_control_bounds(std::vector<double> lower, std::vector<double> upper) {
  if (static_cast<int>(lower.size()) != nu() || static_cast<int>(upper.size()) != nu())
    throw std::invalid_argument("control bounds need one number per control");
  lower_ = std::move(lower);
  upper_ = std::move(upper);
}

void KnotModel::set_free_duration(const FreeDuration& duration) {
  if (!held_ || duration.memory < 0 || duration.memory >= memory_)
    throw std::invalid_argument("a free duration needs its place in a held memory");
  if (integrator_ == Integrator::none || integrator_ == Integrator::discrete ||
      integrator_ == Integrator::impulse)
    throw std::invalid_argument("what knows no time step has no free duration");
  duration_ = duration;
}

bool KnotModel::has_control_bounds() const {
  const auto finite = [](double a) { return std::isfinite(a); };
  return std::any_of(lower_.begin(), lower_.end(), finite) ||
         std::any_of(upper_.begin(), upper_.end(), finite);
}

int KnotModel::jacobian_rows() const {
  if (integrator_ == Integrator::none) return 0;
  return semi_implicit() ? system_->nv() : ndx();
}

template <class S>
void KnotModel::evaluate_costs(const KnotInput<S>& in, KnotWorkspace<S>& work) const {
  work.cost = S(0.0);
  for (std::size_t t = 0; t < costs_.size(); ++t) {
    const CostTerm& term = costs_[t];
    const ResidualInput<S> input{in.x, in.u, in.parameters + term.parameters, *work.system_};
    S* r = term.is_barrier() ? work.constraint.data() + term.row : work.residual_.data();
    term.residual->evaluate(input, r);
    const S scale = in.cost_scale * in.parameters[term.weight];
    work.term_costs[t] = scale * term.activation.value(r, term.residual->size());
    work.cost += work.term_costs[t];
  }
}

namespace {

/// gradient ← Aᵀ gradient and W = Aᵀ diag(diagonal) A (k x k) for A with k columns, by rows.
template <class S>
void pull_back(const std::vector<double>& A, int rows, int k, const S* diagonal, S* gradient,
               S* W) {
  S pulled[6];
  std::fill_n(pulled, k, S(0.0));
  std::fill_n(W, k * k, S(0.0));
  for (int r = 0; r < rows; ++r) {
    const double* row = &A[r * k];
    for (int i = 0; i < k; ++i) {
      if (row[i] == 0) continue;
      pulled[i] += gradient[r] * row[i];
      const S scaled = diagonal[r] * row[i];
      for (int j = 0; j <= i; ++j)
        if (row[j] != 0) W[i * k + j] += scaled * row[j];
    }
  }
  for (int i = 0; i < k; ++i)
    for (int j = 0; j < i; ++j) W[j * k + i] = W[i * k + j];
  std::copy_n(pulled, k, gradient);
}

}  // namespace

template <class S>
void KnotModel::differentiate_costs(const KnotInput<S>& in, KnotWorkspace<S>& work,
                                    bool hessian) const {
  work.cost = S(0.0);
  std::fill(work.gradient.begin(), work.gradient.end(), S(0.0));
  if (hessian) {
    const auto rest = work.hessian.begin() + lasting_entries_;
    std::fill(work.hessian.begin(), rest, S(0.0));
    if (!work.rest_is_zero_) std::fill(rest, work.hessian.end(), S(0.0));
    work.rest_is_zero_ = true;
  }
  for (std::size_t t = 0; t < costs_.size(); ++t) {
    const CostTerm& term = costs_[t];
    const bool barrier = term.is_barrier();
    const LinearImage* image = term.residual->linear_image();
    const Residual& inner = image ? *image->of : *term.residual;
    const ResidualInput<S> input{in.x, in.u, in.parameters + term.parameters, *work.system_};
    S* r = barrier ? work.constraint.data() + term.row : work.residual_.data();
    S* jacobian =
        barrier ? work.constraint_jacobian.data() + term.jacobian : work.residual_jacobian_.data();
    S* gradient = work.activation_gradient_.data();
    S* diagonal = work.activation_diagonal_.data();
    if (image && !barrier)
      term.residual->evaluate(input, r);
    else
      term.residual->differentiate(input, r, jacobian);
    const S scale = in.cost_scale * in.parameters[term.weight];
    const int rows = term.residual->size();
    S rank_one;
    const S value = term.activation.differentiate(r, rows, gradient, diagonal, rank_one);
    work.term_costs[t] = scale * value;
    work.cost += work.term_costs[t];
    if (barrier) {
      if (all_zero(gradient, rows) && all_zero(diagonal, rows)) continue;
      if (hessian) work.rest_is_zero_ = false;
    }
    S W[36];
    if (image) {
      jacobian = work.residual_jacobian_.data();
      inner.differentiate(input, work.residual_.data(), jacobian);
      pull_back(image->A, rows, inner.size(), diagonal, gradient, W);
    }
    const bool dense = term.activation.kind == ActivationKind::smooth_l2;
    if (dense) std::fill(work.term_gradient_.begin(), work.term_gradient_.end(), S(0.0));
    const int* pair = pattern_index_[t].data();
    for (const RowBlock& block : inner.blocks()) {
      const int columns = static_cast<int>(block.columns.size());
      S* weighted = work.weighted_jacobian_.data();
      for (int c = 0; c < columns; ++c) {
        const S* column = jacobian + c * block.rows;
        S g = column[0] * gradient[0];
        for (int i = 1; i < block.rows; ++i) g += column[i] * gradient[i];
        work.gradient[block.columns[c]] += scale * g;
        if (dense) work.term_gradient_[block.columns[c]] += g;
        if (!hessian) continue;
        if (!image) {
          for (int i = 0; i < block.rows; ++i) *weighted++ = scale * diagonal[i] * column[i];
          continue;
        }
        for (int i = 0; i < block.rows; ++i) {
          S sum = W[i * block.rows] * column[0];
          for (int j = 1; j < block.rows; ++j) sum += W[i * block.rows + j] * column[j];
          *weighted++ = scale * sum;
        }
      }
      if (hessian) {
        add_products(block.rows, columns, jacobian, work.weighted_jacobian_.data(), pair,
                     work.hessian.data());
        pair += columns * (columns + 1) / 2;
      }
      jacobian += block.rows * columns;
      gradient += block.rows;
      diagonal += block.rows;
    }
    if (!dense || !hessian) continue;
    const S factor = scale * rank_one;
    for (int row = 0; row < nz(); ++row)
      for (int column = 0; column <= row; ++column)
        work.hessian[*pair++] += factor * work.term_gradient_[row] * work.term_gradient_[column];
  }
}

template <class S>
void KnotModel::evaluate(const KnotInput<S>& given, KnotWorkspace<S>& work) const {
  const KnotInput<S> in = at_its_duration(given);
  if (integrator_ == Integrator::none) {
    system_->update_kinematics(in.x, *work.system_);
    evaluate_costs(in, work);
    evaluate_constraints(in, work);
    return;
  }
  system_->evaluate(in.x, in.u, *work.system_);
  evaluate_costs(in, work);
  evaluate_constraints(in, work);
  integrate(*system_, integrator_, in.x, in.u, in.dt, *work.system_, work.integrator_);
  if (memory_ > 0) append_control_memory(in, work, false);
}

template <class S>
void KnotModel::differentiate(const KnotInput<S>& given, KnotWorkspace<S>& work,
                              bool hessian) const {
  const KnotInput<S> in = at_its_duration(given);
  if (integrator_ == Integrator::none) {
    system_->update_kinematics(in.x, *work.system_);
    differentiate_costs(in, work, hessian);
    differentiate_constraints(in, work, hessian);
    return;
  }
  system_->differentiate(in.x, in.u, *work.system_);
  differentiate_costs(in, work, hessian);
  differentiate_constraints(in, work, hessian);
  integrate_derivatives(*system_, integrator_, in.x, in.u, in.dt, *work.system_, work.integrator_);
  if (memory_ > 0) append_control_memory(in, work, true);
  if (duration_) append_duration(given, work);
}

template <class S>
KnotWorkspace<S>::KnotWorkspace(const KnotModel& model)
    : cost(0.0),
      term_costs(model.costs().size(), S(0.0)),
      gradient(model.nz(), S(0.0)),
      hessian(model.hessian_pattern().size(), S(0.0)),
      augmentation(0.0),
      constraint(model.constraint_rows(), S(0.0)),
      constraint_jacobian(model.constraint_pattern().size(), S(0.0)),
      memory_(model.nx() > model.system().nx()),
      system_(model.system().create_data(S{})),
      integrator_(model.system(), model.integrator(), model.free_duration().has_value()),
      term_gradient_(model.nz(), S(0.0)) {
  if (memory_) {
    next_.assign(model.nx(), S(0.0));
    F_.assign(model.jacobian_rows() * model.nz(), S(0.0));
  }
  int rows = 0, entries = 0;
  const auto make_room = [&](const Residual& residual) {
    rows = std::max(rows, residual.size());
    entries = std::max(entries, residual.jacobian_size());
  };
  for (const CostTerm& term : model.costs()) {
    make_room(*term.residual);
    // A residual may have fewer rows than the one of which it is an image.
    if (const LinearImage* image = term.residual->linear_image()) make_room(*image->of);
  }
  int constraint_rows = 0;
  for (const ConstraintTerm& term : model.constraints()) {
    make_room(*term.residual);
    entries = std::max(entries, term.jacobian_size());
    constraint_rows = std::max(constraint_rows, term.rows);
  }
  shifted_.assign(constraint_rows, S(0.0));
  weight_.assign(constraint_rows, S(0.0));
  curvature_.assign(constraint_rows * constraint_rows, S(0.0));
  soft_.assign(2 * constraint_rows, S(0.0));
  residual_.assign(rows, S(0.0));
  residual_jacobian_.assign(entries, S(0.0));
  weighted_jacobian_.assign(entries, S(0.0));
  activation_gradient_.assign(rows, S(0.0));
  activation_diagonal_.assign(rows, S(0.0));
}

#define CONDDP_INSTANTIATE(S)                                                      \
  template class KnotWorkspace<S>;                                                 \
  template void KnotModel::evaluate(const KnotInput<S>&, KnotWorkspace<S>&) const; \
  template void KnotModel::differentiate(const KnotInput<S>&, KnotWorkspace<S>&, bool) const;
CONDDP_FOR_EACH_SCALAR(CONDDP_INSTANTIATE)
#undef CONDDP_INSTANTIATE

}  // namespace conddp
