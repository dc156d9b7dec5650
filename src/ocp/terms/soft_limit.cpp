#include "ocp/terms/soft_limit.hpp"

#include <cmath>

namespace conddp {
namespace {

/// √(Σp²), bounded away from zero so that unselected lanes and their derivatives stay finite.
template <class S>
S length(const S* p, int n) {
  S sum(1e-200);
  for (int i = 0; i < n; ++i) sum += p[i] * p[i];
  return sqrt(sum);
}

}  // namespace

template <class S>
void limit_cone(int n, const S& limit, S* p) {
  const S a = length(p, n);
  const S share = select(a <= limit, S(1.0), limit / a);
  for (int i = 0; i < n; ++i) p[i] *= share;
}

template <class S>
void limit_cone_derivative(const S* p, int n, const S& limit, S* derivative) {
  const S a = length(p, n), share = limit / a, inverse = S(1.0) / a;
  const auto within = a <= limit;
  for (int j = 0; j < n; ++j)
    for (int i = 0; i < n; ++i) {
      S& entry = derivative[j * n + i];
      entry = select(within, entry, share * (entry - (p[i] * inverse) * (p[j] * inverse)));
    }
}

#define CONDDP_INSTANTIATE(S)                  \
  template void limit_cone(int, const S&, S*); \
  template void limit_cone_derivative(const S*, int, const S&, S*);
CONDDP_FOR_EACH_SCALAR(CONDDP_INSTANTIATE)
#undef CONDDP_INSTANTIATE

double soft_distance(const ConstraintTerm& term, const double* g, const double* lower,
                     const double* upper, double power) {
  if (!term.has_bounds()) return std::pow(distance_to_set(term, g, lower, upper), power);
  double sum = 0;
  for (int i = 0; i < term.rows; ++i)
    sum += std::pow(std::abs(outside_bounds(g[i], lower[i], upper[i])), power);
  return sum;
}

double soft_cost(const ConstraintTerm& term, const double* g, const double* parameters,
                 double cost_scale) {
  if (term.softness == Softness::hard || parameters[term.active()] == 0) return 0;
  const double* lower = term.has_bounds() ? parameters + term.lower() : nullptr;
  const double* upper = term.has_bounds() ? parameters + term.upper() : nullptr;
  const double weight = cost_scale * parameters[term.weight()];
  return term.softness == Softness::l1 ? weight * soft_distance(term, g, lower, upper, 1)
                                       : 0.5 * weight * soft_distance(term, g, lower, upper, 2);
}

}  // namespace conddp
