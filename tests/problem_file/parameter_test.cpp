// Constants and tables with file-wide names.

#include <gtest/gtest.h>

#include "problem_file/expand/expand_problem.hpp"
#include "problem_text.hpp"
#include "support/temporary_folder.hpp"

namespace conddp {
namespace {

constexpr std::string_view kScaled = R"(conddp: 1
parameters:
  mass: 2
  weight: =9.81*mass
  goal: [1, "=mass/4"]
system:
  states: {x: m, v: m/s}
  controls: {u: N}
  rate: {x: v, v: u/mass - goal.y}
initial_state: {state: =-goal}
phases: [{knots: 4, dt: =0.2/mass}]
costs:
  effort: {residual: control, weight: "=2^mass", reference: =weight}
  own: {residual: expression, rows: [x*mass], reference: "=goal[0]"}
solver: {name: box_fddp}
)";

double rate_of(const Loaded& loaded) {
  EXPECT_TRUE(loaded.built) << loaded.all();
  const System& system = *loaded.built->plant.system;
  const auto data = system.create_data(0.0);
  const double x[] = {1, 0}, u = 6;
  system.evaluate(x, &u, *data);
  return data->f[1];
}

TEST(Parameters, ReplaceNumbersAndNamesInExpressions) {
  const Loaded loaded{std::string(kScaled)};
  EXPECT_EQ(rate_of(loaded), 6.0 / 2 - 0.5);
  EXPECT_EQ(loaded.built->problem->initial_state(), (std::vector<double>{-1, -0.5}));
  EXPECT_EQ(loaded.spec->phases[0].dt, 0.1);
  EXPECT_EQ(loaded.spec->costs[0].weight, 4);
  const KnotView knot = loaded.built->problem->knot(0);
  EXPECT_EQ(knot.parameters[0], 9.81 * 2);
  EXPECT_EQ(knot.parameters[knot.model->costs()[1].parameters], 1);
}

TEST(Parameters, SettingsReachDependentValues) {
  const Loaded loaded(std::string(kScaled), {"parameters.mass=4", "parameters.goal.0==mass"});
  EXPECT_EQ(rate_of(loaded), 6.0 / 4 - 1);
  EXPECT_EQ(loaded.built->problem->initial_state(), (std::vector<double>{-4, -1}));
  EXPECT_EQ(loaded.spec->phases[0].dt, 0.05);
  EXPECT_EQ(loaded.spec->costs[0].weight, 16);
}

TEST(Parameters, ExpandedFileHasTheirValues) {
  const Loaded loaded{std::string(kScaled)};
  ASSERT_TRUE(loaded.built) << loaded.all();
  const std::string text = expanded_text(*loaded.built);
  EXPECT_EQ(text.find(": ="), std::string::npos) << text;
  const Loaded again(text);
  EXPECT_EQ(rate_of(again), rate_of(loaded));
  EXPECT_EQ(expanded_text(*again.built), text);
  EXPECT_EQ(again.spec->names.parameters[2].second.numbers, (std::vector<double>{1, 0.5}));
}

TEST(Parameters, FormulaMatchesItsValue) {
  const Loaded formula{std::string(kScaled)};
  const Loaded value(replaced(kScaled, "=0.2/mass", "0.1"));
  EXPECT_EQ(formula.spec->definition, value.spec->definition);
}

TEST(Parameters, ErrorsPointIntoTheFormula) {
  struct WrongFile {
    std::string from, to, error;
  };
  const WrongFile cases[] = {
      {"=0.2/mass", "=0.2/mas", "11:30: unknown name 'mas'"},
      {"\"=2^mass\"", "\"=2^mas\"", "13:43: unknown name 'mas'"},
      {"=9.81*mass", "=9.81*goal", "4:17: unknown name 'goal'"},
      {"=9.81*mass", "=9.81*", "4:17: the expression ends where"},
      {"=9.81*mass", "=", "4:12: the expression is empty"},
      {"=9.81*mass", "=1/0", "4:13: the value of '/' is not finite"},
      {"=9.81*mass", "heavy", "4:11: "},
      {"=0.2/mass", "=mass > 1", "11:25: a number or a vector is expected here, not a condition"},
      {"=0.2/mass", "=goal", "11:25: "},
      {"mass: 2", "2mass: 2", "3:3: '2mass' is not a name of expressions"},
      {"mass: 2", "sin: 2", "3:3: 'sin' is a function of the expression language"},
      {"goal: [1, \"=mass/4\"]", "goal: []", "5:9: a vector has at least one number"},
      {"goal: [", "x: [", "5:3: the name 'x' is taken"},
      {"controls: {u: N}", "controls: {u: N}\n  parameters: {mass: 1}",
       "9:16: the name 'mass' is taken"},
  };
  for (const WrongFile& c : cases) {
    std::string text = replaced(kScaled, c.from, c.to);
    if (c.to == "x: [")
      text = replaced(replaced(replaced(text, "goal.y", "2"), "=-goal", "[0, 0]"), "=goal[0]", "0");
    const Loaded loaded(text);
    EXPECT_FALSE(loaded.built) << c.to;
    EXPECT_TRUE(loaded.first_error().starts_with(c.error)) << c.to << "\n" << loaded.all();
  }
}

TEST(Parameters, NamesAndDescriptionsAreNotFormulas) {
  const Loaded loaded(replaced(kScaled, "conddp: 1", "conddp: 1\ndescription: = as it was"));
  ASSERT_TRUE(loaded.built) << loaded.all();
  EXPECT_EQ(loaded.spec->description, "= as it was");
}

TEST(Parameters, RobotsSupportThem) {
  const Loaded loaded(R"(conddp: 1
parameters: {reach: 0.7}
robot: {urdf: robots/cartpole.urdf, actuation: {joints: [slider]}}
initial_state: {joints: {hinge: =reach/2}}
phases: [{knots: 4, dt: 0.05}]
costs: {far: {residual: expression, rows: "q[slider] - reach"}}
solver: {name: box_fddp}
)");
  ASSERT_TRUE(loaded.built) << loaded.all();
  const auto columns = loaded.built->state_columns;
  const std::size_t hinge = columns[0].name == "q/hinge" ? 0 : 1;
  EXPECT_EQ(loaded.built->problem->initial_state()[hinge], 0.35);
  const Loaded taken(replaced(R"(conddp: 1
parameters: {reach: 0.7}
robot: {urdf: robots/cartpole.urdf, actuation: {joints: [slider]}}
initial_state: {}
phases: [{knots: 4, dt: 0.05}]
costs: {far: {residual: expression, rows: "q[slider]"}}
)",
                              "reach", "q"));
  EXPECT_EQ(taken.first_error(), "2:14: the name 'q' is taken");
}

constexpr std::string_view kFromFile = R"(conddp: 1
tables:
  drag: {file: drag.csv, x: speed, y: force}
system:
  states: [x, v]
  controls: [u]
  rate: {x: v, v: u - drag(v)}
initial_state: {state: [0, 0]}
phases: [{knots: 4, dt: 0.1}]
costs: {loss: {residual: expression, rows: drag(v)*v}}
)";

/// The problem and its table in a separate folder.
struct InFolder {
  explicit InFolder(const std::string& csv, const std::string& text = std::string(kFromFile)) {
    const TemporaryFolder folder;
    folder.write("drag.csv", csv);
    spec = read_problem_text(text, folder / "test.yaml", {}, out);
    if (spec) built = build_problem(*spec, {}, out);
  }
  Diagnostics out;
  std::optional<ProblemSpec> spec;
  std::optional<BuiltProblem> built;
};

TEST(Tables, FileColumnsAreKnownToAllExpressions) {
  const InFolder loaded("speed [m/s],force [N],t\n0,0,9\n1,1,8\n2,4,7\n");
  ASSERT_TRUE(loaded.built) << format_diagnostics(loaded.out, false);
  const System& system = *loaded.built->plant.system;
  const auto data = system.create_data(0.0);
  const double x[] = {0, 2}, u = 1;
  system.evaluate(x, &u, *data);
  EXPECT_NEAR(data->f[1], 1 - 4, 1e-14);
  ASSERT_EQ(loaded.out.data_files().size(), 1u);
  const Loaded again(expanded_text(*loaded.built));
  ASSERT_TRUE(again.built) << again.all();
  EXPECT_EQ(again.spec->names.tables[0].values, (std::vector<double>{0, 1, 4}));
}

TEST(Tables, ReportErrorsInTheFile) {
  const auto error = [](const InFolder& loaded) {
    return loaded.out.list().empty()
               ? std::string()
               : fmt::format("{}:{}: {}", loaded.out.list()[0].line, loaded.out.list()[0].column,
                             loaded.out.list()[0].message);
  };
  EXPECT_TRUE(error(InFolder("sped,force\n0,0\n")).starts_with("3:29: "))
      << error(InFolder("sped,force\n0,0\n"));
  EXPECT_TRUE(
      error(InFolder("speed,force\n0,0\n1,\n")).starts_with("3:39: the column 'force' of '"));
  EXPECT_EQ(error(InFolder("speed,force\n1,0\n0,1\n")),
            "3:9: the points of a table have to be finite and ascending");
  EXPECT_TRUE(error(InFolder("speed,force\n0,x\n1,2\n")).starts_with("2:3: in the column 'force'"));
  EXPECT_TRUE(
      error(InFolder("speed,force\n0,0\n1,2\n", replaced(kFromFile, "drag.csv", "drug.csv")))
          .starts_with("3:16: "));
  EXPECT_EQ(error(InFolder("speed,force\n0,0\n1,2\n", replaced(kFromFile, ", y: force", ""))),
            "3:9: 'tables.drag' lacks the key 'y'");
}

}  // namespace
}  // namespace conddp
