// The certificate of every example answer holds; other tests check answers of `ipopt` against known
// optima.
#include <fstream>
#include <iterator>

#include "output/report/certificate_report.hpp"
#include "support/transcribed_problem.hpp"

namespace conddp {
namespace {

class CertificateOf : public ::testing::TestWithParam<std::string> {};

TEST_P(CertificateOf, TheAnswerHolds) {
  const testing::ReadyProblem ready(GetParam());
  const SolverInfo& solver = *find_solver(ready.spec.solver.name.value);
  const SolveResult result =
      solve(*ready.built.problem, solver, ready.spec.solver.options, ready.built.guess);
  const OrderedJson document =
      OrderedJson::parse(solution_json({ready.built, solver, result, {}}).dump());
  const SolutionCertificate certificate = certify_solution(document, ready.built, false);
  EXPECT_TRUE(certificate.checks.holds()) << certificate_table(certificate.checks);
}

INSTANTIATE_TEST_SUITE_P(Ready, CertificateOf,
                         ::testing::ValuesIn(testing::without("ipopt",
                                                              testing::ready_problems(false))),
                         testing::name_of);
INSTANTIATE_TEST_SUITE_P(Legs, CertificateOf, ::testing::ValuesIn(testing::ready_problems(true)),
                         testing::name_of);

}  // namespace
}  // namespace conddp
