#include "ocp/terms/activation.hpp"

namespace conddp {

namespace {

/// √(s + ε²) − ε without cancellation for small s.
template <class S>
S smooth_norm(const S& square, double epsilon) {
  return square / (sqrt(square + S(epsilon * epsilon)) + S(epsilon));
}

}  // namespace

template <class S>
S Activation::weighted_square(const S* r, int n) const {
  S sum(0.0);
  for (int i = 0; i < n; ++i) sum += r[i] * r[i] * weight(i);
  return sum;
}

template <class S>
S Activation::value(const S* r, int n) const {
  S sum(0.0);
  switch (kind) {
    case ActivationKind::quadratic:
      return S(0.5) * weighted_square(r, n);
    case ActivationKind::quadratic_barrier:
      for (int i = 0; i < n; ++i) {
        const S below = min(r[i] - S(lower[i]), S(0.0)), above = max(r[i] - S(upper[i]), S(0.0));
        sum += (below * below + above * above) * weight(i);
      }
      return S(0.5) * sum;
    case ActivationKind::smooth_l1:
      for (int i = 0; i < n; ++i) sum += smooth_norm(r[i] * r[i], epsilon) * weight(i);
      return sum;
    case ActivationKind::smooth_l2:
      return smooth_norm(weighted_square(r, n), epsilon);
    case ActivationKind::linear:
      for (int i = 0; i < n; ++i) sum += r[i] * weight(i);
      return sum;
  }
  return sum;
}

template <class S>
S Activation::differentiate(const S* r, int n, S* gradient, S* diagonal, S& rank_one) const {
  rank_one = S(0.0);
  switch (kind) {
    case ActivationKind::quadratic:
      return differentiate_quadratic(r, n, gradient, diagonal);
    case ActivationKind::quadratic_barrier:
      return differentiate_barrier(r, n, gradient, diagonal);
    case ActivationKind::smooth_l1:
      return differentiate_smooth_l1(r, n, gradient, diagonal);
    case ActivationKind::smooth_l2:
      return differentiate_smooth_l2(r, n, gradient, diagonal, rank_one);
    case ActivationKind::linear:
      return differentiate_linear(r, n, gradient, diagonal);
  }
  return S(0.0);
}

template <class S>
S Activation::differentiate_quadratic(const S* r, int n, S* gradient, S* diagonal) const {
  S sum(0.0);
  for (int i = 0; i < n; ++i) {
    gradient[i] = r[i] * weight(i);
    diagonal[i] = S(weight(i));
    sum += gradient[i] * r[i];
  }
  return S(0.5) * sum;
}

template <class S>
S Activation::differentiate_barrier(const S* r, int n, S* gradient, S* diagonal) const {
  S sum(0.0);
  for (int i = 0; i < n; ++i) {
    const S below = r[i] - S(lower[i]), above = r[i] - S(upper[i]);
    const S outside = min(below, S(0.0)) + max(above, S(0.0));
    gradient[i] = outside * weight(i);
    diagonal[i] =
        select(below < S(0.0), S(weight(i)), select(above > S(0.0), S(weight(i)), S(0.0)));
    sum += gradient[i] * outside;
  }
  return S(0.5) * sum;
}

template <class S>
S Activation::differentiate_smooth_l1(const S* r, int n, S* gradient, S* diagonal) const {
  S sum(0.0);
  for (int i = 0; i < n; ++i) {
    const S square = r[i] * r[i], root = sqrt(square + S(epsilon * epsilon));
    const S inverse = S(1.0) / root;
    gradient[i] = r[i] * inverse * weight(i);
    diagonal[i] = inverse * inverse * inverse * (epsilon * epsilon * weight(i));
    sum += square / (root + S(epsilon)) * weight(i);
  }
  return sum;
}

template <class S>
S Activation::differentiate_smooth_l2(const S* r, int n, S* gradient, S* diagonal,
                                      S& rank_one) const {
  const S sum = weighted_square(r, n);
  const S root = sqrt(sum + S(epsilon * epsilon));
  const S inverse = S(1.0) / root;
  for (int i = 0; i < n; ++i) {
    gradient[i] = r[i] * inverse * weight(i);
    diagonal[i] = inverse * weight(i);
  }
  rank_one = -inverse;
  return sum / (root + S(epsilon));
}

template <class S>
S Activation::differentiate_linear(const S* r, int n, S* gradient, S* diagonal) const {
  S sum(0.0);
  for (int i = 0; i < n; ++i) {
    gradient[i] = S(weight(i));
    diagonal[i] = S(0.0);
    sum += r[i] * weight(i);
  }
  return sum;
}

#define CONDDP_INSTANTIATE(S)                        \
  template S Activation::value(const S*, int) const; \
  template S Activation::differentiate(const S*, int, S*, S*, S&) const;
CONDDP_INSTANTIATE(double)
CONDDP_INSTANTIATE(Lane)
CONDDP_INSTANTIATE(Dual<Lane>)
#undef CONDDP_INSTANTIATE

}  // namespace conddp
