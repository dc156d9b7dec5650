#include "systems/closed_forms/catalogue.hpp"

#include <stdexcept>

#include "systems/closed_form.hpp"
#include "systems/graphs/compiled_system.hpp"
#include "systems/graphs/graph.hpp"

namespace conddp {
namespace {

/// A closed form that takes its second derivatives from its expressions, recorded in GraphNumber.
template <class Derived>
class CatalogueSystem : public ClosedFormSystem<Derived> {
 public:
  using ClosedFormSystem<Derived>::ClosedFormSystem;

  std::unique_ptr<SecondDerivatives> second_derivatives(SystemData<Lane>&,
                                                        SystemData<Dual<Lane>>&) const override {
    return hessian_.derivatives(*this);
  }

 private:
  SystemExpressions record() const {
    SystemExpressions recorded;
    ExpressionGraph& graph = recorded.graph;
    std::vector<GraphNumber> numbers, f(this->rows());
    for (int i = 0; i < this->nx() + this->nu(); ++i) {
      recorded.sources.push_back(i);
      numbers.emplace_back(graph, graph.input(i));
    }
    static_cast<const Derived&>(*this).rate(numbers.data(), numbers.data() + this->nx(), f.data());
    for (const GraphNumber& number : f) recorded.outputs.push_back(number.node(graph));
    return recorded;
  }

  SystemHessian hessian_{[this] { return record(); }};
};

class DoubleIntegrator : public CatalogueSystem<DoubleIntegrator> {
 public:
  explicit DoubleIntegrator(int n)
      : CatalogueSystem(SystemKind::second_order, StateManifold::flat(2 * n), n) {
    for (const char* kind : {"q/", "v/", "u/"})
      for (int i = 0; i < n; ++i) {
        const bool control = kind[0] == 'u';
        (control ? control_columns_ : state_columns_)
            .push_back({kind + std::to_string(i), kind[0] == 'q' ? "m"
                                                  : control      ? "m/s2"
                                                                 : "m/s"});
      }
  }
  template <class S>
  void rate(const S*, const S* u, S* f) const {
    for (int i = 0; i < nu(); ++i) f[i] = u[i];
  }
};

class LinearSystem : public CatalogueSystem<LinearSystem> {
 public:
  LinearSystem(const Eigen::MatrixXd& A, const Eigen::MatrixXd& B, const Eigen::VectorXd& c,
               SystemKind kind)
      : CatalogueSystem(kind, StateManifold::flat(static_cast<int>(A.rows())),
                        static_cast<int>(B.cols())),
        A_(A),
        B_(B),
        c_(c) {
    if (A.rows() != A.cols() || B.rows() != A.rows() || c.size() != A.rows())
      throw std::invalid_argument("a linear system needs A (n x n), B (n x m) and c (n)");
    for (int i = 0; i < nx(); ++i) state_columns_.push_back({"x/" + std::to_string(i), "1"});
    for (int i = 0; i < nu(); ++i) control_columns_.push_back({"u/" + std::to_string(i), "1"});
  }
  template <class S>
  void rate(const S* x, const S* u, S* f) const {
    for (int i = 0; i < nx(); ++i) {
      f[i] = S(c_[i]);
      for (int j = 0; j < nx(); ++j) f[i] += x[j] * A_(i, j);
      for (int j = 0; j < nu(); ++j) f[i] += u[j] * B_(i, j);
    }
  }

 private:
  Eigen::MatrixXd A_, B_;
  Eigen::VectorXd c_;
};

class Pendulum : public CatalogueSystem<Pendulum> {
 public:
  explicit Pendulum(const PendulumParameters& p)
      : CatalogueSystem(SystemKind::second_order, StateManifold::flat(2), 1), p_(p) {
    state_columns_ = {{"theta", "rad"}, {"omega", "rad/s"}};
    control_columns_ = {{"torque", "Nm"}};
  }
  template <class S>
  void rate(const S* x, const S* u, S* f) const {
    f[0] = (u[0] - S(p_.mass * p_.gravity * p_.length) * sin(x[0]) - x[1] * S(p_.damping)) *
           S(1 / p_.inertia);
  }

 private:
  PendulumParameters p_;
};

class Cartpole : public CatalogueSystem<Cartpole> {
 public:
  explicit Cartpole(const CartpoleParameters& p)
      : CatalogueSystem(SystemKind::second_order, StateManifold::flat(4), 1), p_(p) {
    state_columns_ = {{"x", "m"}, {"theta", "rad"}, {"vx", "m/s"}, {"omega", "rad/s"}};
    control_columns_ = {{"force", "N"}};
  }
  template <class S>
  void rate(const S* x, const S* u, S* f) const {
    S s, c;
    sincos(x[1], s, c);
    const S m(p_.pole_mass), l(p_.length), g(p_.gravity);
    const S scale = S(1.0) / (S(p_.cart_mass) + m * s * s);
    const S push = u[0] + m * l * s * x[3] * x[3];
    f[0] = scale * (push + m * g * s * c);
    f[1] = -(scale / l) * (push * c + S(p_.cart_mass + p_.pole_mass) * g * s);
  }

 private:
  CartpoleParameters p_;
};

class Acrobot : public CatalogueSystem<Acrobot> {
 public:
  explicit Acrobot(const AcrobotParameters& p)
      : CatalogueSystem(SystemKind::second_order, StateManifold::flat(4), 1), p_(p) {
    state_columns_ = {
        {"theta1", "rad"}, {"theta2", "rad"}, {"omega1", "rad/s"}, {"omega2", "rad/s"}};
    control_columns_ = {{"elbow", "Nm"}};
  }
  template <class S>
  void rate(const S* x, const S* u, S* f) const {
    const auto& p = p_;
    S s2, c2;
    sincos(x[1], s2, c2);
    // As in the public model, link masses are at the ends of the links.
    const S coupling = S(p.mass2 * p.length1 * p.length2);
    const S m11 = S((p.mass1 + p.mass2) * p.length1 * p.length1 + p.mass2 * p.length2 * p.length2 +
                    p.inertia1 + p.inertia2) +
                  S(2.0) * coupling * c2;
    const S m12 = S(p.mass2 * p.length2 * p.length2 + p.inertia2) + coupling * c2;
    const S m22 = S(p.mass2 * p.length2 * p.length2 + p.inertia2);
    const S h = coupling * s2;
    const S c12 = cos(x[0] + x[1]);
    const S b1 = -(h * x[3] * x[3]) - S(2.0) * h * x[2] * x[3] +
                 S((p.mass1 + p.mass2) * p.length1 * p.gravity) * cos(x[0]) +
                 S(p.mass2 * p.length2 * p.gravity) * c12;
    const S b2 = h * x[2] * x[2] + S(p.mass2 * p.length2 * p.gravity) * c12;
    const S t1 = -b1 - x[2] * S(p.friction);
    const S t2 = u[0] - b2 - x[3] * S(p.friction);
    const S determinant = S(1.0) / (m11 * m22 - m12 * m12);
    f[0] = determinant * (m22 * t1 - m12 * t2);
    f[1] = determinant * (m11 * t2 - m12 * t1);
  }

 private:
  AcrobotParameters p_;
};

class Unicycle : public CatalogueSystem<Unicycle> {
 public:
  Unicycle() : CatalogueSystem(SystemKind::first_order, StateManifold::flat(3), 2) {
    state_columns_ = {{"x", "m"}, {"y", "m"}, {"theta", "rad"}};
    control_columns_ = {{"v", "m/s"}, {"omega", "rad/s"}};
  }
  template <class S>
  void rate(const S* x, const S* u, S* f) const {
    S s, c;
    sincos(x[2], s, c);
    f[0] = u[0] * c;
    f[1] = u[0] * s;
    f[2] = u[1];
  }
};

class Car : public CatalogueSystem<Car> {
 public:
  Car(double wheelbase, double step)
      : CatalogueSystem(SystemKind::discrete, StateManifold::flat(4), 2),
        wheelbase_(wheelbase),
        step_(step) {
    state_columns_ = {{"x", "m"}, {"y", "m"}, {"theta", "rad"}, {"v", "m/s"}};
    control_columns_ = {{"steering", "rad"}, {"acceleration", "m/s2"}};
  }
  template <class S>
  void rate(const S* x, const S* u, S* f) const {
    S sw, cw, st, ct;
    sincos(u[0], sw, cw);
    sincos(x[2], st, ct);
    const S d(wheelbase_);
    const S front = x[3] * S(step_);
    const S lateral = front * sw;
    const S back = d + front * cw - sqrt(d * d - lateral * lateral);
    f[0] = x[0] + back * ct;
    f[1] = x[1] + back * st;
    f[2] = x[2] + asin(lateral * S(1 / wheelbase_));
    f[3] = x[3] + u[1] * S(step_);
  }

 private:
  double wheelbase_, step_;
};

class PlanarQuadrotor : public CatalogueSystem<PlanarQuadrotor> {
 public:
  explicit PlanarQuadrotor(const PlanarQuadrotorParameters& p)
      : CatalogueSystem(SystemKind::second_order, StateManifold::flat(6), 2), p_(p) {
    state_columns_ = {{"x", "m"},    {"z", "m"},    {"theta", "rad"},
                      {"vx", "m/s"}, {"vz", "m/s"}, {"omega", "rad/s"}};
    control_columns_ = {{"right", "N"}, {"left", "N"}};
  }
  template <class S>
  void rate(const S* x, const S* u, S* f) const {
    S s, c;
    sincos(x[2], s, c);
    const S thrust = (u[0] + u[1]) * S(1 / p_.mass);
    f[0] = -(thrust * s);
    f[1] = thrust * c - S(p_.gravity);
    f[2] = (u[0] - u[1]) * S(p_.arm / p_.inertia);
  }

 private:
  PlanarQuadrotorParameters p_;
};

StateManifold free_body() {
  StateManifold m;
  m.append(StateManifold::Part::se3);
  m.append(StateManifold::Part::flat, 6);
  return m;
}

class Quadrotor : public CatalogueSystem<Quadrotor> {
 public:
  explicit Quadrotor(const QuadrotorParameters& p)
      : CatalogueSystem(SystemKind::second_order, free_body(), 4), p_(p) {
    for (const char* name : {"x", "y", "z"}) state_columns_.push_back({name, "m"});
    for (const char* name : {"qx", "qy", "qz", "qw"}) state_columns_.push_back({name, "1"});
    for (const char* name : {"vx", "vy", "vz"}) state_columns_.push_back({name, "m/s"});
    for (const char* name : {"wx", "wy", "wz"}) state_columns_.push_back({name, "rad/s"});
    for (const char* name : {"front", "left", "back", "right"})
      control_columns_.push_back({name, "N"});
  }
  template <class S>
  void rate(const S* x, const S* u, S* f) const {
    const Matrix3<S> r = rotation_matrix(Quaternion<S>{x[3], x[4], x[5], x[6]});
    const Vector3<S> v{x[7], x[8], x[9]}, w{x[10], x[11], x[12]};
    const Vector3<S> g = transpose_times(r, Vector3<S>{S(0.0), S(0.0), S(-p_.gravity)});
    const Vector3<S> turning = cross(w, v);
    const S thrust = (u[0] + u[1] + u[2] + u[3]) * S(1 / p_.mass);
    f[0] = g.x - turning.x;
    f[1] = g.y - turning.y;
    f[2] = g.z - turning.z + thrust;
    f[3] = (S(p_.arm) * (u[1] - u[3]) - S(p_.jz - p_.jy) * w.y * w.z) * S(1 / p_.jx);
    f[4] = (S(p_.arm) * (u[2] - u[0]) - S(p_.jx - p_.jz) * w.z * w.x) * S(1 / p_.jy);
    f[5] = (S(p_.torque_ratio) * (u[0] - u[1] + u[2] - u[3]) - S(p_.jy - p_.jx) * w.x * w.y) *
           S(1 / p_.jz);
  }

 private:
  QuadrotorParameters p_;
};

class Lander : public CatalogueSystem<Lander> {
 public:
  explicit Lander(const LanderParameters& p)
      : CatalogueSystem(SystemKind::first_order, StateManifold::flat(7), 3), p_(p) {
    for (const char* name : {"x", "y", "z"}) state_columns_.push_back({name, "m"});
    for (const char* name : {"vx", "vy", "vz"}) state_columns_.push_back({name, "m/s"});
    state_columns_.push_back({"burnt", "kg"});
    for (const char* name : {"tx", "ty", "tz"}) control_columns_.push_back({name, "N"});
  }
  template <class S>
  void rate(const S* x, const S* u, S* f) const {
    const S per_mass = S(1.0) / (S(p_.mass) - x[6]);
    S square(kThrustRounding * kThrustRounding);
    for (int i = 0; i < 3; ++i) {
      f[i] = x[3 + i];
      f[3 + i] = u[i] * per_mass;
      square += u[i] * u[i];
    }
    f[5] -= S(p_.gravity);
    f[6] = S(p_.fuel_rate) * sqrt(square);
  }

 private:
  LanderParameters p_;
};

}  // namespace

std::shared_ptr<const System> double_integrator(int dimension) {
  return std::make_shared<DoubleIntegrator>(dimension);
}
std::shared_ptr<const System> linear_system(const Eigen::MatrixXd& A, const Eigen::MatrixXd& B,
                                            const Eigen::VectorXd& c, SystemKind kind) {
  return std::make_shared<LinearSystem>(A, B, c, kind);
}
std::shared_ptr<const System> pendulum(const PendulumParameters& p) {
  return std::make_shared<Pendulum>(p);
}
std::shared_ptr<const System> cartpole(const CartpoleParameters& p) {
  return std::make_shared<Cartpole>(p);
}
std::shared_ptr<const System> acrobot(const AcrobotParameters& p) {
  return std::make_shared<Acrobot>(p);
}
std::shared_ptr<const System> unicycle() { return std::make_shared<Unicycle>(); }
std::shared_ptr<const System> car(double wheelbase, double step) {
  return std::make_shared<Car>(wheelbase, step);
}
std::shared_ptr<const System> planar_quadrotor(const PlanarQuadrotorParameters& p) {
  return std::make_shared<PlanarQuadrotor>(p);
}
std::shared_ptr<const System> quadrotor(const QuadrotorParameters& p) {
  return std::make_shared<Quadrotor>(p);
}
std::shared_ptr<const System> lander(const LanderParameters& p) {
  return std::make_shared<Lander>(p);
}

}  // namespace conddp
