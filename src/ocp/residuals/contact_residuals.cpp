#include <numbers>
#include <stdexcept>

#include "ocp/residuals/residuals.hpp"
#include "ocp/residuals/system_columns.hpp"

namespace conddp {
namespace {

constexpr double kInfinity = std::numeric_limits<double>::infinity();

void check(const FrictionLimits& limits) {
  if (!(limits.friction > 0)) throw std::invalid_argument("friction must be positive");
  if (!(limits.min_normal >= 0) || !(limits.max_normal > limits.min_normal))
    throw std::invalid_argument("normal forces need 0 <= minimum < maximum");
}

LinearCone upper_bounded(int rows, int columns) {
  return {Eigen::MatrixXd::Zero(rows, columns), std::vector<double>(rows, -kInfinity),
          std::vector<double>(rows, 0.0)};
}

/// Sets a row to the normal force and its bounds.
void bound_normal_force(const FrictionLimits& limits, int row, LinearCone& cone) {
  cone.lower[row] = limits.min_normal;
  cone.upper[row] = limits.max_normal;
}

using SystemPointer = std::shared_ptr<const MultibodySystem>;

/// One contact of a system, and the derivative of its force in the axes of its base or its frame.
class ContactOf {
 public:
  ContactOf(SystemPointer system, int contact, int ndx)
      : system_(std::move(system)),
        index_(contact),
        columns_(system_->mimic_map(), support(system_->robot(), spec().pair())) {
    z_columns_ = column_range(0, system_->ndx());
    for (const int c : column_range(ndx, system_->nu())) z_columns_.push_back(c);
  }

  const Contact& spec() const { return system_->contacts().contacts()[index_]; }
  /// Columns of z that affect the force.
  const std::vector<int>& columns() const { return z_columns_; }

  template <class S>
  const ContactData<S>& data(const ResidualInput<S>& in) const {
    return multibody_data(in).contacts.contacts[index_];
  }

  /// Calls put(column, change of the force) for every column, in the axes of the base
  /// (world_aligned) or of the frame.
  template <class S, class F>
  void for_each_column(const ResidualInput<S>& in, FrameAxes axes, F put) const {
    auto& system = multibody_data(in);
    const ContactData<S>& contact = data(in);
    const int m = system_->contacts().rows(), first = system_->contacts().offset(index_);
    const bool turns = frame_turns_force(axes);
    const S* jacobian = contact.frame_jacobian.data();
    if (turns && !columns_.identity()) {
      columns_.gather(jacobian, 6, system.columns.data());
      jacobian = system.columns.data();
    }
    int next = 0;  // index of the columns that rotate the frame
    for (int c = 0; c < static_cast<int>(z_columns_.size()); ++c) {
      Force<S> change = change_in_frame(contact, &system.contacts.force_z[c * m + first]);
      if (turns && next < columns_.count() && columns_.columns()[next] == c) {
        const S* turn = jacobian + 6 * next++ + 3;
        add_turn(contact.local, {turn[0], turn[1], turn[2]}, axes, change);
      }
      if (axes == FrameAxes::world_aligned)
        change = {contact.relative.R * change.linear, contact.relative.R * change.angular};
      put(c, change);
    }
  }

 private:
  /// True if the force acts along the contact's own directions instead of its frame's axes.
  bool has_directions() const {
    return spec().kind == ContactKind::normal || spec().kind == ContactKind::planar;
  }
  /// Rotating the frame turns a body-fixed force as seen from the base, and a base-fixed force as
  /// seen from the body.
  bool frame_turns_force(FrameAxes axes) const {
    const bool fixed_in_base = has_directions() && spec().axes == FrameAxes::world_aligned;
    return fixed_in_base == (axes == FrameAxes::local);
  }
  /// Change of a force due to a rotation w of the frame, in the given axes.
  template <class S>
  static void add_turn(const Force<S>& force, const Vector3<S>& w, FrameAxes axes,
                       Force<S>& change) {
    if (axes == FrameAxes::local) {
      change.linear += cross(force.linear, w);
      return;
    }
    change.linear += cross(w, force.linear);
    change.angular += cross(w, force.angular);
  }
  /// Change of the force due to a change of its rows, in the axes of its frame.
  template <class S>
  Force<S> change_in_frame(const ContactData<S>& contact, const S* rows) const {
    Force<S> change = Force<S>::zero();
    if (has_directions()) {
      for (int i = 0; i < spec().rows(); ++i) change.linear += rows[i] * contact.directions[i];
      return change;
    }
    change.linear = {rows[0], rows[1], rows[2]};
    if (spec().kind == ContactKind::surface) change.angular = {rows[3], rows[4], rows[5]};
    return change;
  }

  SystemPointer system_;
  int index_;
  ReducedColumns columns_;  ///< columns that move the frame or its base
  std::vector<int> z_columns_;
};

/// A contact's force, with or without its torque, in axes of the base or of the frame.
class ContactForce : public ResidualBase<ContactForce> {
 public:
  ContactForce(ContactOf contact, FrameAxes axes, int rows, bool has_reference)
      : ResidualBase({{rows, contact.columns()}}, has_reference ? rows : 0, false),
        contact_(std::move(contact)),
        axes_(axes) {}

  Reads reads() const override { return Reads::forces; }
  template <class S>
  void evaluate_as(const ResidualInput<S>& in, S* r) const {
    const ContactData<S>& data = contact_.data(in);
    const Force<S> f = axes_ == FrameAxes::local ? data.local : contact_force_in_base(data);
    for (int i = 0; i < size(); ++i) r[i] = f[i];
    for (int i = 0; i < parameter_count(); ++i) r[i] -= in.parameters[i];
  }
  template <class S>
  void differentiate_as(const ResidualInput<S>& in, S* r, S* jacobian) const {
    evaluate_as(in, r);
    const int n = size();
    contact_.for_each_column(in, axes_, [&](int c, const Force<S>& change) {
      for (int i = 0; i < n; ++i) jacobian[c * n + i] = change[i];
    });
  }

 private:
  ContactOf contact_;
  FrameAxes axes_;
};

class ContactCone : public ResidualBase<ContactCone> {
 public:
  ContactCone(ContactOf contact, const LinearCone& cone)
      : ResidualBase({{static_cast<int>(cone.A.rows()), contact.columns()}}, 0, false),
        contact_(std::move(contact)),
        columns_(static_cast<int>(cone.A.cols())),
        axes_(columns_ == 6 ? FrameAxes::local : FrameAxes::world_aligned),
        image_{std::make_shared<ContactForce>(contact_, axes_, columns_, false),
               std::vector<double>(cone.A.size())} {
    for (int i = 0; i < cone.A.rows(); ++i)
      for (int j = 0; j < columns_; ++j) image_.A[i * columns_ + j] = cone.A(i, j);
  }

  const LinearImage* linear_image() const override { return &image_; }
  Reads reads() const override { return Reads::forces; }
  template <class S>
  void evaluate_as(const ResidualInput<S>& in, S* r) const {
    const ContactData<S>& data = contact_.data(in);
    multiply(axes_ == FrameAxes::local ? data.local : contact_force_in_base(data), r);
  }
  template <class S>
  void differentiate_as(const ResidualInput<S>& in, S* r, S* jacobian) const {
    evaluate_as(in, r);
    contact_.for_each_column(
        in, axes_, [&](int c, const Force<S>& change) { multiply(change, jacobian + c * size()); });
  }

 private:
  template <class S>
  void multiply(const Force<S>& f, S* r) const {
    const double* a = image_.A.data();
    for (int i = 0; i < size(); ++i) {
      r[i] = f[0] * S(*a++);
      for (int j = 1; j < columns_; ++j) r[i] += f[j] * S(*a++);
    }
  }
  ContactOf contact_;
  int columns_;
  FrameAxes axes_;
  LinearImage image_;
};

class FrictionCone : public ResidualBase<FrictionCone> {
 public:
  FrictionCone(ContactOf contact, double friction, const Vector3<double>& normal)
      : ResidualBase({{2, contact.columns()}}, 0, false),
        contact_(std::move(contact)),
        friction_(friction),
        normal_(normal) {}

  Reads reads() const override { return Reads::forces; }
  template <class S>
  void evaluate_as(const ResidualInput<S>& in, S* r) const {
    Vector3<S> tangential;
    split(contact_force_in_base(contact_.data(in)).linear, r[1], tangential);
    r[0] = length(tangential) - S(friction_) * r[1];
  }
  template <class S>
  void differentiate_as(const ResidualInput<S>& in, S* r, S* jacobian) const {
    Vector3<S> tangential;
    split(contact_force_in_base(contact_.data(in)).linear, r[1], tangential);
    const S size = length(tangential);
    r[0] = size - S(friction_) * r[1];
    const Vector3<S> direction = (S(1.0) / size) * tangential;
    contact_.for_each_column(in, FrameAxes::world_aligned, [&](int c, const Force<S>& change) {
      S* column = jacobian + 2 * c;
      column[1] = dot(normal_.cast<S>(), change.linear);
      column[0] = dot(direction, change.linear) - S(friction_) * column[1];
    });
  }

 private:
  template <class S>
  void split(const Vector3<S>& force, S& normal, Vector3<S>& tangential) const {
    normal = dot(normal_.cast<S>(), force);
    tangential = force - normal * normal_.cast<S>();
  }
  template <class S>
  static S length(const Vector3<S>& tangential) {
    return sqrt(squared_norm(tangential) + S(kConeSmoothing * kConeSmoothing));
  }
  ContactOf contact_;
  double friction_;
  Vector3<double> normal_;
};

}  // namespace

std::shared_ptr<const Residual> contact_force_residual(const SystemPointer& system, int contact,
                                                       int ndx) {
  const ContactOf of(system, contact, ndx);
  const int rows = of.spec().kind == ContactKind::surface ? 6 : 3;
  return std::make_shared<ContactForce>(of, FrameAxes::world_aligned, rows, true);
}
std::shared_ptr<const Residual> contact_cone_residual(const SystemPointer& system, int contact,
                                                      int ndx, const LinearCone& cone) {
  return std::make_shared<ContactCone>(ContactOf(system, contact, ndx), cone);
}
std::shared_ptr<const Residual> friction_cone_residual(const SystemPointer& system, int contact,
                                                       int ndx, double friction,
                                                       const Vector3<double>& normal) {
  return std::make_shared<FrictionCone>(ContactOf(system, contact, ndx), friction, normal);
}

Matrix3<double> rotation_to_normal(const Vector3<double>& n) {
  // Rodrigues' formula with the axis (−y, x, 0); for −z, a half turn about x.
  const double c = n.z;
  if (c < -1 + 1e-12) return {{1, 0, 0, 0, -1, 0, 0, 0, -1}};
  const double k = 1 / (1 + c);
  return {{1 - n.x * n.x * k, -n.x * n.y * k, n.x, -n.x * n.y * k, 1 - n.y * n.y * k, n.y, -n.x,
           -n.y, c}};
}

LinearCone friction_pyramid(const FrictionLimits& limits, int faces, bool inner,
                            const Vector3<double>& normal) {
  check(limits);
  if (faces < 3) throw std::invalid_argument("a pyramid has at least three faces");
  const double mu = limits.friction * (inner ? std::cos(std::numbers::pi / faces) : 1);
  const Matrix3<double> R = rotation_to_normal(normal);
  LinearCone cone = upper_bounded(faces + 1, 3);
  for (int i = 0; i < faces; ++i) {
    const double angle = 2 * std::numbers::pi * i / faces;
    const Vector3<double> row = R * Vector3<double>{std::cos(angle), std::sin(angle), -mu};
    cone.A.row(i) << row.x, row.y, row.z;
  }
  cone.A.row(faces) << normal.x, normal.y, normal.z;
  bound_normal_force(limits, faces, cone);
  return cone;
}

LinearCone center_of_pressure_cone(double half_x, double half_y) {
  LinearCone cone = upper_bounded(4, 6);
  cone.A.row(0) << 0, 0, -half_y, 1, 0, 0;
  cone.A.row(1) << 0, 0, -half_y, -1, 0, 0;
  cone.A.row(2) << 0, 0, -half_x, 0, 1, 0;
  cone.A.row(3) << 0, 0, -half_x, 0, -1, 0;
  return cone;
}

LinearCone wrench_cone(const FrictionLimits& limits, double half_x, double half_y, bool inner) {
  check(limits);
  const double mu = limits.friction * (inner ? std::numbers::sqrt2 / 2 : 1);
  LinearCone cone = upper_bounded(17, 6);
  int row = 0;
  for (const double sign : {1.0, -1.0}) {
    cone.A.row(row++) << sign, 0, -mu, 0, 0, 0;
    cone.A.row(row++) << 0, sign, -mu, 0, 0, 0;
  }
  cone.A.middleRows(row, 4) = center_of_pressure_cone(half_x, half_y).A;
  row += 4;
  // τ_min ≤ τ_z ≤ τ_max: each of the two sums of absolute values gives four inequalities.
  for (const double side : {1.0, -1.0})
    for (const double a : {1.0, -1.0})
      for (const double b : {1.0, -1.0})
        cone.A.row(row++) << a * half_y, b * half_x, -mu * (half_x + half_y), side * a * mu,
            side * b * mu, side;
  cone.A(row, 2) = 1;
  bound_normal_force(limits, row, cone);
  return cone;
}

}  // namespace conddp
