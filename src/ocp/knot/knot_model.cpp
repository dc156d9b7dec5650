#include "ocp/knot/knot_model.hpp"

#include <numeric>
#include <stdexcept>

#include "ocp/knot/gauss_newton.hpp"

namespace conddp {
namespace {

std::vector<QuadratureStage> quadrature_of(const System& system, Integrator integrator) {
  const IntegratorInfo& info = info_of(integrator);
  std::vector<QuadratureStage> stages;
  if (info.order < 2) return stages;
  if (const auto* collocation = system.as_collocation()) {
    stages.push_back({0, collocation->weight(0)});
    for (int i = 1; i <= collocation->later_stages(); ++i)
      stages.push_back({collocation->time(i), collocation->weight(i)});
    return stages;
  }
  for (int i = 0; i < info.rule.stages; ++i)
    stages.push_back({std::accumulate(info.rule.a[i], info.rule.a[i] + i, 0.0), info.rule.b[i]});
  return stages;
}

}  // namespace

KnotModel::KnotModel(Step step)
    : step_(std::move(step)),
      parameter_count_(step_.parameter_count()),
      lower_(nu(), -std::numeric_limits<double>::infinity()),
      upper_(nu(), std::numeric_limits<double>::infinity()),
      quadrature_(quadrature_of(system(), integrator())) {}

int KnotModel::add_cost(std::string name, std::shared_ptr<const Residual> residual,
                        Activation activation, const std::optional<FreeDuration>& grows_with,
                        bool integrated) {
  check_fit("cost " + name, *residual, step_.has_control(), nz());
  if (grows_with) step_.check_duration(*grows_with);
  if (integrated && quadrature_.empty())
    throw std::invalid_argument("cost " + name + " cannot be integrated");
  CostTerm& term = costs_.emplace_back();
  term.name = std::move(name);
  term.parameters = parameter_count_;
  const int stages = integrated ? static_cast<int>(quadrature_.size()) : 1;
  term.weight = parameter_count_ + stages * residual->parameter_count();
  parameter_count_ = term.weight + 1;
  term.residual = std::move(residual);
  term.activation = std::move(activation);
  term.grows_with = grows_with;
  term.integrated = integrated;
  if (term.is_barrier()) {
    term.row = constraint_rows_;
    term.jacobian = add_rows(term.residual->blocks());
  }
  index_hessian();
  return term.parameters;
}

namespace {

/// Pattern of a symmetric matrix, filled in order of first use: (row, column), row ≥ column.
class PatternIndex {
 public:
  PatternIndex(int size, std::vector<std::pair<int, int>>& pattern)
      : size_(size), entry_at_(size * size, -1), pattern_(pattern) {
    for (std::size_t i = 0; i < pattern.size(); ++i)
      entry_at_[pattern[i].second * size + pattern[i].first] = static_cast<int>(i);
  }

  /// Indices of the pairs of columns of each block.
  std::vector<int> entries(const std::vector<RowBlock>& blocks) {
    std::size_t pairs = 0;
    for (const RowBlock& block : blocks)
      pairs += block.columns.size() * (block.columns.size() + 1) / 2;
    std::vector<int> entries;
    entries.reserve(pairs);
    for (const RowBlock& block : blocks)
      for (std::size_t a = 0; a < block.columns.size(); ++a)
        for (std::size_t b = 0; b <= a; ++b)
          entries.push_back(entry(block.columns[a], block.columns[b]));
    return entries;
  }

 private:
  int entry(int row, int column) {
    int& entry = entry_at_[column * size_ + row];
    if (entry < 0) {
      entry = static_cast<int>(pattern_.size());
      pattern_.emplace_back(row, column);
    }
    return entry;
  }

  int size_;
  std::vector<int> entry_at_;
  std::vector<std::pair<int, int>>& pattern_;
};

}  // namespace

void KnotModel::index_hessian() {
  const int n = nz();
  std::size_t first = pattern_index_.size(), first_constraint = constraint_pattern_index_.size();
  if (static_cast<std::size_t>(lasting_entries_) < pattern_.size()) {
    // Rebuild the pattern: lasting entries must come before all others.
    pattern_.clear();
    first = first_constraint = 0;
  }
  PatternIndex index(n, pattern_), stage_index(n, stage_pattern_);
  pattern_index_.resize(costs_.size());
  constraint_pattern_index_.resize(constraints_.size());
  for (const bool rests : {false, true}) {
    for (std::size_t t = first; t < costs_.size(); ++t) {
      if (costs_[t].is_barrier() != rests) continue;  // a barrier is zero inside its bounds
      std::vector<RowBlock> blocks = costs_[t].residual->blocks();
      if (costs_[t].activation.kind == ActivationKind::smooth_l2)
        blocks.push_back({1, column_range(0, n)});
      pattern_index_[t] = (costs_[t].integrated ? stage_index : index).entries(blocks);
      if (costs_[t].integrated) stage_index_ = index.entries({{1, column_range(0, n)}});
    }
    if (!rests) lasting_entries_ = static_cast<int>(pattern_.size());
  }
  for (std::size_t t = first_constraint; t < constraints_.size(); ++t)
    constraint_pattern_index_[t] = index.entries(constraints_[t].blocks);
  index_stage_columns();
}

void KnotModel::index_stage_columns() {
  stage_places_.assign(nz(), -1);
  for (const auto& [row, column] : stage_pattern_) stage_places_[row] = stage_places_[column] = 0;
  stage_columns_.clear();
  for (int c = 0; c < nz(); ++c) {
    if (stage_places_[c] < 0) continue;
    stage_places_[c] = static_cast<int>(stage_columns_.size());
    stage_columns_.push_back(c);
  }
}

void KnotModel::set_control_bounds(std::vector<double> lower, std::vector<double> upper) {
  if (static_cast<int>(lower.size()) != nu() || static_cast<int>(upper.size()) != nu())
    throw std::invalid_argument("control bounds need one number per control");
  lower_ = std::move(lower);
  upper_ = std::move(upper);
}

bool KnotModel::has_control_bounds() const {
  const auto finite = [](double a) { return std::isfinite(a); };
  return std::any_of(lower_.begin(), lower_.end(), finite) ||
         std::any_of(upper_.begin(), upper_.end(), finite);
}

template <class S>
ResidualInput<S> KnotModel::input_of(const CostTerm& term, const CostPoint<S>& at) const {
  return residual_input(term.parameters + at.stage * term.residual->parameter_count(), at.in,
                        at.system);
}

/// Evaluates all but the integrated costs, whose sums start from zero.
template <class S>
void KnotModel::evaluate_costs(const KnotInput<S>& in, KnotWorkspace<S>& work) const {
  work.cost = S(0.0);
  std::fill(work.term_costs.begin(), work.term_costs.end(), S(0.0));
  for (std::size_t t = 0; t < costs_.size(); ++t)
    if (!costs_[t].integrated) evaluate_cost(t, CostPoint<S>{in, *work.step_.system}, work);
}

template <class S>
void KnotModel::evaluate_cost(std::size_t t, const CostPoint<S>& at, KnotWorkspace<S>& work) const {
  const CostTerm& term = costs_[t];
  S* r = term.is_barrier() ? work.constraint.data() + term.row : work.residual_.data();
  term.residual->evaluate(input_of(term, at), r);
  const S scale = scale_of(term, at.in);
  work.term_costs[t] = scale * term.activation.value(r, term.residual->size());
  work.cost += work.term_costs[t];
}

/// Slope and curvature of a cost's activation with respect to the rows of its residual. If the
/// residual is a linear image A r, W is the curvature with respect to r.
template <class S>
struct CostSlopes {
  S scale;
  S *gradient, *diagonal;
  const S* jacobian = nullptr;  ///< of the rows
  S rank_one{};
  const S* W = nullptr;  ///< by rows
};

namespace {

/// gradient ← Aᵀ gradient and W = Aᵀ diag(diagonal) A (k x k, by rows) for A with k columns, by
/// rows.
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

/// out ← scale · curvature · column of the Jacobian, where the curvature is W or, if null, the
/// diagonal. Returns the end of the output.
template <class S>
S* weigh_column(const S& scale, const S* diagonal, const S* W, const S* column, int rows, S* out) {
  if (W == nullptr) {
    for (int i = 0; i < rows; ++i) *out++ = scale * diagonal[i] * column[i];
    return out;
  }
  for (int i = 0; i < rows; ++i) *out++ = scale * dot(rows, W + i * rows, column);
  return out;
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
  std::fill(work.term_costs.begin(), work.term_costs.end(), S(0.0));
  for (std::size_t t = 0; t < costs_.size(); ++t) {
    if (costs_[t].integrated) continue;
    differentiate_cost(t, CostPoint<S>{in, *work.step_.system}, work, hessian);
    add_growth(costs_[t].grows_with, work.term_costs[t], in.x, work);
  }
}

namespace {

/// Destination of the values and Jacobian of a cost's residual: for a barrier, its constraint rows.
/// For a linear image that is not a barrier, only the values are written.
template <class S>
struct RowsOfCost {
  S *values, *jacobian;
};

template <class S>
void differentiate_residual(const CostTerm& term, const ResidualInput<S>& input,
                            const RowsOfCost<S>& rows) {
  if (term.residual->linear_image() && !term.is_barrier())
    term.residual->evaluate(input, rows.values);
  else
    term.residual->differentiate(input, rows.values, rows.jacobian);
}

}  // namespace

/// Computes the value of a cost and its slopes with respect to the rows of its residual. False for
/// a barrier that adds nothing.
template <class S>
inline bool KnotModel::find_slopes(std::size_t t, const CostPoint<S>& at, KnotWorkspace<S>& work,
                                   bool hessian, CostSlopes<S>& slopes) const {
  const CostTerm& term = costs_[t];
  const bool barrier = term.is_barrier();
  const RowsOfCost<S> to =
      barrier ? RowsOfCost<S>{work.constraint.data() + term.row,
                              work.constraint_jacobian.data() + term.jacobian}
              : RowsOfCost<S>{work.residual_.data(), work.residual_jacobian_.data()};
  differentiate_residual<S>(term, input_of(term, at), to);
  slopes = {.scale = scale_of(term, at.in),
            .gradient = work.activation_gradient_.data(),
            .diagonal = work.activation_diagonal_.data(),
            .jacobian = to.jacobian};
  const int rows = term.residual->size();
  const S value = term.activation.differentiate(to.values, rows, slopes.gradient, slopes.diagonal,
                                                slopes.rank_one);
  work.term_costs[t] = slopes.scale * value;
  work.cost += work.term_costs[t];
  if (!barrier) return true;
  if (all_zero(slopes.gradient, rows) && all_zero(slopes.diagonal, rows)) return false;
  if (hessian) work.rest_is_zero_ = false;
  return true;
}

template <class S>
void KnotModel::differentiate_cost(std::size_t t, const CostPoint<S>& at, KnotWorkspace<S>& work,
                                   bool hessian) const {
  const CostTerm& term = costs_[t];
  CostSlopes<S> slopes{};
  if (!find_slopes(t, at, work, hessian, slopes)) return;
  S W[36];
  const Residual* inner = term.residual.get();
  if (const LinearImage* image = term.residual->linear_image()) {
    const ResidualInput<S> input = input_of(term, at);
    inner = image->of.get();
    inner->differentiate(input, work.residual_.data(), work.residual_jacobian_.data());
    slopes.jacobian = work.residual_jacobian_.data();
    pull_back(image->A, term.residual->size(), inner->size(), slopes.diagonal, slopes.gradient, W);
    slopes.W = W;
  }
  const bool dense = term.activation.kind == ActivationKind::smooth_l2;
  const int* pair =
      add_cost(inner->blocks(), slopes, dense, hessian, pattern_index_[t].data(), work);
  if (dense && hessian) add_rank_one(slopes.scale * slopes.rank_one, pair, work);
}

/// Adds gradient and Gauss-Newton Hessian of a cost. `pair` lists the indices of its pairs of
/// columns in the pattern; returns the end of those used. `dense`: also fills term_gradient_.
template <class S>
const int* KnotModel::add_cost(const std::vector<RowBlock>& blocks, const CostSlopes<S>& slopes,
                               bool dense, bool hessian, const int* pair,
                               KnotWorkspace<S>& work) const {
  if (dense) std::fill(work.term_gradient_.begin(), work.term_gradient_.end(), S(0.0));
  const S scale = slopes.scale;
  const S *gradient = slopes.gradient, *diagonal = slopes.diagonal, *W = slopes.W;
  const S* jacobian = slopes.jacobian;
  for (const RowBlock& block : blocks) {
    const int columns = static_cast<int>(block.columns.size());
    S* weighted = work.weighted_jacobian_.data();
    for (int c = 0; c < columns; ++c) {
      const S* column = jacobian + c * block.rows;
      const S g = dot(block.rows, column, gradient);
      work.gradient[block.columns[c]] += scale * g;
      if (dense) work.term_gradient_[block.columns[c]] += g;
      if (hessian) weighted = weigh_column(scale, diagonal, W, column, block.rows, weighted);
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
  return pair;
}

/// Hessian += factor · term_gradient_ term_gradient_ᵀ.
template <class S>
void KnotModel::add_rank_one(const S& factor, const int* pair, KnotWorkspace<S>& work) const {
  for (int row = 0; row < nz(); ++row)
    for (int column = 0; column <= row; ++column)
      work.hessian[*pair++] += factor * work.term_gradient_[row] * work.term_gradient_[column];
}

template <class S>
void KnotModel::begin(const KnotInput<S>& in, KnotWorkspace<S>& work, bool derivatives) const {
  if (step_.has_control())
    step_.begin({in.x, in.u, in.parameters, in.dt}, work.step_, derivatives);
  else if (!costs_.empty() || !constraints_.empty())
    system().update_kinematics(in.x, *work.step_.system);
}

template <class S>
void KnotModel::evaluate(const KnotInput<S>& given, KnotWorkspace<S>& work) const {
  const KnotInput<S> in = has_units() ? in_own_units(given, work) : given;
  begin(in, work, false);
  evaluate_costs(in, work);
  evaluate_constraints(in, work);
  if (integrator() == Integrator::none) return;
  take_step(in, work, {});
  if (has_units()) give_values_in_units(work);
}

template <class S>
void KnotModel::differentiate(const KnotInput<S>& given, KnotWorkspace<S>& work,
                              bool hessian) const {
  const KnotInput<S> in = has_units() ? in_own_units(given, work) : given;
  begin(in, work, true);
  differentiate_costs(in, work, hessian);
  differentiate_constraints(in, work, hessian);
  if (integrator() != Integrator::none)
    take_step(in, work, {.derivatives = true, .hessian = hessian});
  if (!has_units()) return;
  if (integrator() != Integrator::none) give_values_in_units(work);
  give_derivatives_in_units(work, hessian);
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
      has_units_(model.has_units()),
      step_(model.step()),
      term_gradient_(model.nz(), S(0.0)) {
  if (model.has_units()) {
    own_x_.assign(model.nx(), S(0.0));
    own_u_.assign(model.nu(), S(0.0));
    given_next_.assign(model.nx(), S(0.0));
    given_F_.assign(model.jacobian_rows() * model.nz(), S(0.0));
  }
  int rows = 0, entries = 0;
  const auto make_room = [&](const Residual& residual) {
    rows = std::max(rows, residual.size());
    entries = std::max(entries, residual.jacobian_size());
  };
  for (const CostTerm& term : model.costs()) {
    make_room(*term.residual);
    // A linear image may have fewer rows than the residual inside it.
    if (const LinearImage* image = term.residual->linear_image()) make_room(*image->of);
  }
  if (!model.stage_index_.empty()) {
    const std::size_t columns = model.stage_columns_.size();
    stage_x_.assign(model.nx(), S(0.0));
    stage_gradient_.assign(model.nz(), S(0.0));
    stage_hessian_.assign(model.stage_pattern_.size(), S(0.0));
    stage_dense_.assign(columns * columns, S(0.0));
    stage_Z_.assign(columns * model.nz(), S(0.0));
    stage_HZ_.assign(columns * model.nz(), S(0.0));
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

#define CONDDP_INSTANTIATE(S)                                                                      \
  template class KnotWorkspace<S>;                                                                 \
  template void KnotModel::evaluate_cost(std::size_t, const CostPoint<S>&, KnotWorkspace<S>&)      \
      const;                                                                                       \
  template void KnotModel::differentiate_cost(std::size_t, const CostPoint<S>&, KnotWorkspace<S>&, \
                                              bool) const;                                         \
  template void KnotModel::evaluate(const KnotInput<S>&, KnotWorkspace<S>&) const;                 \
  template void KnotModel::differentiate(const KnotInput<S>&, KnotWorkspace<S>&, bool) const;
CONDDP_FOR_EACH_SCALAR(CONDDP_INSTANTIATE)
#undef CONDDP_INSTANTIATE

}  // namespace conddp
