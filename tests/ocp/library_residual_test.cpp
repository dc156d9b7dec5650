// Residuals of compiled functions, compared with the same formulas by hand.
#include "ocp/residuals/library_residual.hpp"

#include <cmath>

#include <gtest/gtest.h>

#include "ocp/knot/knot_model.hpp"
#include "systems/closed_forms/catalogue.hpp"

namespace conddp {
namespace {

/// A function of two states and one control.
std::shared_ptr<const LibraryKnotFunction> compiled(const std::string& name,
                                                    const std::vector<double>& parameters = {}) {
  static const auto library = std::make_shared<const SharedLibrary>(
      "the model", std::initializer_list<const char*>{CONDDP_TEST_MODEL});
  std::optional<LibraryKnotFunction::Defect> defect;
  auto function = LibraryKnotFunction::make(library, name, {2, 1}, parameters, defect);
  EXPECT_TRUE(function) << (defect ? defect->message : "");
  return function;
}

/// Constraint values and Jacobian of a residual at a cart-pole state and a push in scalar S. For
/// dual S, the derivatives of both along the first state.
template <class S>
struct Rows {
  Rows(const std::shared_ptr<const Residual>& residual, std::vector<double> parameters,
       Integrator integrator = Integrator::rk4) {
    KnotModel model(cartpole({}), integrator);
    model.add_constraint(make_constraint("rows", residual, ConstraintKind::bounds));
    parameters.resize(model.parameter_count(), 0.0);
    parameters.back() = 1;
    const AlignedVector<S> given(parameters.begin(), parameters.end());
    const AlignedVector<S> x = {S(0.3), S(-0.7), S(0.2), S(1.1)}, u = {S(2.5)};
    KnotWorkspace<S> work(model);
    const KnotInput<S> in{x.data(), model.nu() > 0 ? u.data() : nullptr, given.data(), S(0.1),
                          S(1.0)};
    model.evaluate(in, work);
    for (int i = 0; i < residual->size(); ++i) evaluated.push_back(work.constraint[i]);
    model.differentiate(in, work, false);
    for (int i = 0; i < residual->size(); ++i) values.push_back(work.constraint[i]);
    jacobian.assign(residual->size(), std::vector<S>(model.nz(), S(0.0)));
    for (std::size_t e = 0; e < model.constraint_pattern().size(); ++e) {
      const auto& [row, column] = model.constraint_pattern()[e];
      jacobian[row][column] = work.constraint_jacobian[e];
    }
  }

  std::vector<S> evaluated, values;
  std::vector<std::vector<S>> jacobian;
};

double number(double value) { return value; }
double number(const Lane& value) { return value[kLaneWidth - 1]; }

template <class S>
void expect_rows(const Rows<S>& rows, const std::vector<double>& values,
                 const std::vector<std::vector<double>>& jacobian) {
  ASSERT_EQ(rows.values.size(), values.size());
  for (std::size_t i = 0; i < values.size(); ++i) {
    EXPECT_NEAR(number(rows.evaluated[i]), values[i], 1e-15) << i;
    EXPECT_NEAR(number(rows.values[i]), values[i], 1e-15) << i;
    ASSERT_EQ(rows.jacobian[i].size(), jacobian[i].size());
    for (std::size_t c = 0; c < jacobian[i].size(); ++c)
      EXPECT_NEAR(number(rows.jacobian[i][c]), jacobian[i][c], 1e-15) << i << ' ' << c;
  }
}

// (1.5 sin(first argument), u times second argument) with the fourth and second state.
TEST(LibraryResidual, ReadsStatesAndControlOfTheKnot) {
  const auto residual =
      make_library_residual(compiled("reach", {1.5}), {.states = {3, 1}, .clock = -1, .ndx = 4});
  EXPECT_TRUE(residual->needs_control());
  EXPECT_EQ(residual->parameter_count(), 2);
  const std::vector<double> values = {1.5 * std::sin(1.1) - 0.4, 2.5 * -0.7 + 0.6};
  const std::vector<std::vector<double>> jacobian = {{0, 0, 0, 1.5 * std::cos(1.1), 0},
                                                     {0, 2.5, 0, 0, -0.7}};
  expect_rows(Rows<double>(residual, {0.4, -0.6}), values, jacobian);
  expect_rows(Rows<Lane>(residual, {0.4, -0.6}), values, jacobian);
}

// (1.5 sin(first argument), u times second argument) with the first and third state.
TEST(LibraryResidual, DifferentiatesByTheFirstColumnToo) {
  const auto residual =
      make_library_residual(compiled("reach", {1.5}), {.states = {0, 2}, .clock = -1, .ndx = 4});
  expect_rows(Rows<double>(residual, {0, 0}), {1.5 * std::sin(0.3), 2.5 * 0.2},
              {{1.5 * std::cos(0.3), 0, 0, 0, 0}, {0, 0, 2.5, 0, 0.2}});
}

TEST(LibraryResidual, ReadsTimeFromClockOrKnot) {
  const auto with_clock =
      make_library_residual(compiled("late"), {.states = {1, 3}, .clock = 2, .ndx = 4});
  EXPECT_EQ(with_clock->parameter_count(), 1);
  expect_rows(Rows<double>(with_clock, {0.25}), {-0.7 - 0.2 - 0.25}, {{0, 1, -1, 0, 0}});
  const auto of_knot =
      make_library_residual(compiled("late"), {.states = {1, 3}, .clock = -1, .ndx = 4});
  EXPECT_EQ(of_knot->parameter_count(), 2);
  EXPECT_FALSE(of_knot->needs_control());
  expect_rows(Rows<double>(of_knot, {0.25, 1.75}), {-0.7 - 1.75 - 0.25}, {{0, 1, 0, 0, 0}});
  // The last node has no control.
  expect_rows(Rows<double>(of_knot, {0.25, 1.75}, Integrator::none), {-0.7 - 1.75 - 0.25},
              {{0, 1, 0, 0}});
}

// Without a Hessian, second derivatives are differences of the Jacobian.
TEST(LibraryResidual, DifferentiatesItsJacobian) {
  const auto residual =
      make_library_residual(compiled("reach", {1.5}), {.states = {3, 1}, .clock = -1, .ndx = 4});
  using D = Dual<Lane>;
  const auto system = cartpole({});
  const auto data = system->create_data(D{});
  AlignedVector<D> x = {D(0.3), D(-0.7), D(0.2), D(1.1)}, u = {D(2.5)}, r(2);
  x[3].d = Lane(1.0);
  u[0].d = Lane(2.0);
  const AlignedVector<D> references = {D(0.4), D(-0.6)};
  AlignedVector<D> packed(residual->jacobian_size());
  residual->differentiate(ResidualInput<D>{x.data(), u.data(), references.data(), *data}, r.data(),
                          packed.data());
  EXPECT_NEAR(r[0].d[0], 1.5 * std::cos(1.1), 1e-12);
  EXPECT_NEAR(r[1].d[0], 2 * -0.7, 1e-12);
  EXPECT_NEAR(packed[0].d[0], -1.5 * std::sin(1.1), 1e-7);  // first row with respect to x3
  EXPECT_NEAR(packed[1].d[0], 2, 1e-7);                     // second row with respect to x1 and u
  EXPECT_NEAR(packed[2].d[0], 0, 1e-7);
}

TEST(LibraryResidual, NamesTheFailedFunction) {
  const auto residual =
      make_library_residual(compiled("edge"), {.states = {1, 3}, .clock = -1, .ndx = 4});
  EXPECT_TRUE(residual->failed_functions().empty());
  const Rows<double> rows(residual, {0, 0});  // undefined at x = −0.7
  EXPECT_TRUE(std::isnan(rows.values[0]) && std::isnan(rows.values[1]));
  EXPECT_FALSE(residual->failed_functions().empty());
  EXPECT_EQ(residual->failed_functions()[0], "edge");
  EXPECT_FALSE(residual->has_claimed_hessian());
  EXPECT_TRUE(make_library_residual(compiled("swing", {2, 5}), {.states = {1, 3}, .ndx = 4})
                  ->has_claimed_hessian());
}

}  // namespace
}  // namespace conddp
