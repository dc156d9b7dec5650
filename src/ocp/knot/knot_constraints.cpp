#include <limits>
#include <stdexcept>

#include "ocp/knot/augmented_term.hpp"
#include "ocp/knot/gauss_newton.hpp"
#include "ocp/knot/knot_model.hpp"
#include "ocp/terms/constraint.hpp"

namespace conddp {

namespace {

/// True if all rows lie inside their set: no multipliers and, unless null, no curvature.
template <class S>
bool all_inside(const ConstraintTerm& term, const S* weight, const S* curvature) {
  const int curvatures = term.is_cone() ? term.rows * term.rows : term.rows;
  return all_zero(weight, term.rows) && (curvature == nullptr || all_zero(curvature, curvatures));
}

}  // namespace

int KnotModel::add_constraint(ConstraintTerm term) {
  check_fit("constraint " + term.name, *term.residual, step_.has_control(), nz());
  term.row = constraint_rows_;
  term.parameters = parameter_count_;
  term.jacobian = add_rows(term.blocks);
  parameter_count_ = term.parameter_end();
  const int parameters = constraints_.emplace_back(std::move(term)).parameters;
  index_hessian();
  return parameters;
}

int KnotModel::add_rows(const std::vector<RowBlock>& blocks) {
  const int first = static_cast<int>(constraint_pattern_.size());
  for (const RowBlock& block : blocks) {
    for (const int column : block.columns)
      for (int i = 0; i < block.rows; ++i)
        constraint_pattern_.emplace_back(constraint_rows_ + i, column);
    constraint_rows_ += block.rows;
  }
  return first;
}

template <class S>
void KnotModel::evaluate_constraints(const KnotInput<S>& in, KnotWorkspace<S>& work) const {
  work.augmentation = S(0.0);
  for (const ConstraintTerm& term : constraints_) {
    const ResidualInput<S> input = residual_input(term.parameters, in, *work.step_.system);
    term.residual->evaluate(input, work.residual_.data());
    S* g = work.constraint.data() + term.row;
    form_value(term, work.residual_.data(), g);
    add_penalty<S>(term, in, work, nullptr);
  }
}

/// Limit on the multipliers of an l1-soft constraint.
template <class S>
S KnotModel::limit_of(const ConstraintTerm& term, const KnotInput<S>& in) const {
  return soft_scale(term, in.cost_scale, in.x) * in.parameters[term.weight()];
}

template <class S>
std::optional<S> KnotModel::add_penalty(const ConstraintTerm& term, const KnotInput<S>& in,
                                        KnotWorkspace<S>& work, S* curvature) const {
  RowPenalty<S> given;
  if (term.softness == Softness::l2) {
    S* of_rows = work.soft_.data();
    const S weight = soft_scale(term, in.cost_scale, in.x) * in.parameters[term.weight()] *
                     in.parameters[term.active()];
    for (int i = 0; i < term.rows; ++i) {
      of_rows[i] = weight;
      of_rows[term.rows + i] = S(0.0);
    }
    given = {of_rows, of_rows + term.rows, of_rows + term.rows};
  } else if (in.penalty != nullptr) {
    given = {in.penalty + term.row, in.shift + term.row, in.multiplier + term.row};
  } else {
    return std::nullopt;
  }
  const RowSet<S> set{in.parameters + term.lower(), in.parameters + term.upper(),
                      term.softness == Softness::l1 ? limit_of(term, in)
                                                    : S(std::numeric_limits<double>::infinity())};
  const S value = augment<S>(term, set, given, work.constraint.data() + term.row,
                             {work.shifted_.data(), work.weight_.data(), curvature});
  (term.softness == Softness::l2 ? work.cost : work.augmentation) += value;
  return value;
}

template <class S>
void KnotModel::differentiate_constraints(const KnotInput<S>& in, KnotWorkspace<S>& work,
                                          bool hessian) const {
  work.augmentation = S(0.0);
  S* curvature = hessian ? work.curvature_.data() : nullptr;
  for (std::size_t t = 0; t < constraints_.size(); ++t) {
    const ConstraintTerm& term = constraints_[t];
    const ResidualInput<S> input = residual_input(term.parameters, in, *work.step_.system);
    term.residual->differentiate(input, work.residual_.data(), work.residual_jacobian_.data());
    S* g = work.constraint.data() + term.row;
    const S norm = form_value(term, work.residual_.data(), g);
    S* jacobian = work.constraint_jacobian.data() + term.jacobian;
    form_jacobian(term, work.residual_.data(), norm, work.residual_jacobian_.data(), jacobian);
    const std::optional<S> value = add_penalty<S>(term, in, work, curvature);
    if (!value) continue;
    if (term.softness == Softness::l2) add_growth(term.grows_with, *value, in.x, work);
    if (all_inside<S>(term, work.weight_.data(), curvature)) continue;
    if (hessian) work.rest_is_zero_ = false;
    add_augmentation(t, jacobian, hessian, work);
  }
}

/// Adds gradient and Gauss-Newton Hessian from the weights and the curvature of a constraint's
/// rows.
template <class S>
void KnotModel::add_augmentation(std::size_t t, const S* jacobian, bool hessian,
                                 KnotWorkspace<S>& work) const {
  const ConstraintTerm& term = constraints_[t];
  const S *weight = work.weight_.data(), *curvature = work.curvature_.data();
  const int* pair = constraint_pattern_index_[t].data();
  for (const RowBlock& block : term.blocks) {
    const int rows = block.rows, columns = static_cast<int>(block.columns.size());
    S* weighted = work.weighted_jacobian_.data();
    for (int c = 0; c < columns; ++c) {
      const S* column = jacobian + c * rows;
      for (int i = 0; i < rows; ++i) work.gradient[block.columns[c]] += column[i] * weight[i];
      if (!hessian) continue;
      for (int i = 0; i < rows; ++i)
        *weighted++ =
            term.is_cone() ? dot(rows, curvature + i * rows, column) : curvature[i] * column[i];
    }
    if (hessian) {
      add_products(rows, columns, jacobian, work.weighted_jacobian_.data(), pair,
                   work.hessian.data());
      pair += columns * (columns + 1) / 2;
    }
    jacobian += rows * columns;
    weight += rows;
    if (!term.is_cone()) curvature += rows;
  }
}

#define CONDDP_INSTANTIATE(S)                                                                      \
  template void KnotModel::evaluate_constraints(const KnotInput<S>&, KnotWorkspace<S>&) const;     \
  template void KnotModel::differentiate_constraints(const KnotInput<S>&, KnotWorkspace<S>&, bool) \
      const;                                                                                       \
  template std::optional<S> KnotModel::add_penalty(const ConstraintTerm&, const KnotInput<S>&,     \
                                                   KnotWorkspace<S>&, S*) const;
CONDDP_FOR_EACH_SCALAR(CONDDP_INSTANTIATE)
#undef CONDDP_INSTANTIATE

}  // namespace conddp
