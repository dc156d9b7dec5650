#include "systems/state_manifold.hpp"

#include <cmath>

#include "spatial/dual.hpp"

namespace conddp {
namespace {

template <class S>
Vector3<S> load3(const S* p) {
  return {p[0], p[1], p[2]};
}
template <class S>
void store3(const Vector3<S>& a, S* p) {
  p[0] = a.x;
  p[1] = a.y;
  p[2] = a.z;
}
template <class S>
Quaternion<S> load_quaternion(const S* p) {
  return {p[0], p[1], p[2], p[3]};
}
template <class S>
void store_quaternion(const Quaternion<S>& a, S* p) {
  p[0] = a.x;
  p[1] = a.y;
  p[2] = a.z;
  p[3] = a.w;
}
template <class S>
Pose<S> load_pose(const S* p) {
  return {load3(p), load_quaternion(p + 3)};
}
template <class S>
Motion<S> load_motion(const S* p) {
  return {load3(p), load3(p + 3)};
}
template <class M, class S>
void store_block(const M& a, int count, S* block) {
  for (int i = 0; i < count; ++i) block[i] = a.m[i];
}

}  // namespace

StateManifold StateManifold::flat(int n) {
  StateManifold m;
  m.append(Part::flat, n);
  return m;
}

void StateManifold::append(Part part, int flat_size) {
  if (part == Part::flat)
    append_flat(flat_size);
  else
    append_curved(part, part == Part::so3 ? 3 : 6);
}

/// Adjacent flat parts are merged into one.
void StateManifold::append_flat(int n) {
  if (n == 0) return;
  if (!segments_.empty() && segments_.back().part == Part::flat)
    segments_.back().n += n;
  else
    segments_.push_back({Part::flat, nx_, ndx_, n});
  nx_ += n;
  ndx_ += n;
}

/// The state has one coordinate more than the tangent space: the part holds a quaternion.
void StateManifold::append_curved(Part part, int n) {
  segments_.push_back({part, nx_, ndx_, n});
  curved_.push_back(segments_.back());
  nx_ += n + 1;
  ndx_ += n;
}

void StateManifold::append(const StateManifold& other) {
  for (const Segment& s : other.segments_) append(s.part, s.n);
}

template <class S>
void StateManifold::integrate(const S* x, const S* dx, S* out) const {
  for (const Segment& s : segments_) {
    const S* a = x + s.x;
    const S* d = dx + s.dx;
    S* o = out + s.x;
    switch (s.part) {
      case Part::flat:
        for (int i = 0; i < s.n; ++i) o[i] = a[i] + d[i];
        break;
      case Part::so3:
        store_quaternion(renormalized(load_quaternion(a) * exp_so3(load3(d))), o);
        break;
      case Part::se3: {
        const Pose<S> r = integrate_se3(load_pose(a), load_motion(d));
        store3(r.p, o);
        store_quaternion(r.q, o + 3);
        break;
      }
    }
  }
}

template <class S>
void StateManifold::difference(const S* x0, const S* x1, S* dx) const {
  for (const Segment& s : segments_) {
    const S* a = x0 + s.x;
    const S* b = x1 + s.x;
    S* d = dx + s.dx;
    switch (s.part) {
      case Part::flat:
        for (int i = 0; i < s.n; ++i) d[i] = b[i] - a[i];
        break;
      case Part::so3:
        store3(log_so3(conjugate(load_quaternion(a)) * load_quaternion(b)), d);
        break;
      case Part::se3: {
        const Motion<S> m = difference_se3(load_pose(a), load_pose(b));
        store3(m.linear, d);
        store3(m.angular, d + 3);
        break;
      }
    }
  }
}

template <class S>
void StateManifold::integrate_jacobians(const S* dx, S* wrt_x, S* wrt_dx) const {
  for (const Segment& s : curved_) {
    const S* d = dx + s.dx;
    if (s.part == Part::so3) {
      store_block(rotation_matrix(exp_so3(-load3(d))), 9, wrt_x);
      store_block(right_jacobian_so3(load3(d)), 9, wrt_dx);
    } else {
      const Motion<S> m = load_motion(d);
      const Pose<S> origin{Vector3<S>::zero(), Quaternion<S>::identity()};
      const Pose<S> back = integrate_se3(origin, Motion<S>{-m.linear, -m.angular});
      store_block(adjoint(placement(back)), 36, wrt_x);
      store_block(right_jacobian_se3(m), 36, wrt_dx);
    }
    wrt_x += kBlockSize;
    wrt_dx += kBlockSize;
  }
}

template <class S>
void StateManifold::inverse_right_jacobian(const S* dx, S* blocks) const {
  for (const Segment& s : curved_) {
    if (s.part == Part::so3)
      store_block(inverse_right_jacobian_so3(load3(dx + s.dx)), 9, blocks);
    else
      store_block(inverse_right_jacobian_se3(load_motion(dx + s.dx)), 36, blocks);
    blocks += kBlockSize;
  }
}

bool StateManifold::normalize(double* x) const {
  for (const Segment& s : curved_) {
    double* q = x + s.x + (s.part == Part::se3 ? 3 : 0);
    const double norm = std::sqrt(q[0] * q[0] + q[1] * q[1] + q[2] * q[2] + q[3] * q[3]);
    if (!(std::abs(norm - 1) < 1e-3)) return false;
    for (int i = 0; i < 4; ++i) q[i] /= norm;
  }
  return true;
}

std::vector<double> StateManifold::neutral() const {
  std::vector<double> x(nx_, 0.0);
  for (const Segment& s : curved_) x[s.x + (s.part == Part::se3 ? 6 : 3)] = 1;
  return x;
}

#define CONDDP_INSTANTIATE(S)                                               \
  template void StateManifold::integrate(const S*, const S*, S*) const;     \
  template void StateManifold::difference(const S*, const S*, S*) const;    \
  template void StateManifold::integrate_jacobians(const S*, S*, S*) const; \
  template void StateManifold::inverse_right_jacobian(const S*, S*) const;
CONDDP_INSTANTIATE(double)
CONDDP_INSTANTIATE(Lane)
CONDDP_INSTANTIATE(Dual<double>)
CONDDP_INSTANTIATE(Dual<Lane>)
CONDDP_INSTANTIATE(Dual<Dual<Lane>>)
#undef CONDDP_INSTANTIATE

}  // namespace conddp
