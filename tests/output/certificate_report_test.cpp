#include "output/report/certificate_report.hpp"

#include <limits>

#include <gtest/gtest.h>

namespace conddp {
namespace {

TEST(OptimalityLine, ShowsGainOfANewtonStepIfAvailable) {
  SolutionCertificate certificate;
  certificate.checks.optimality.stationarity = 1e-8;
  certificate.checks.optimality.expected_decrease = 2e-12;
  EXPECT_NE(optimality_line(certificate).find("; a Newton step would gain 2.0e-12"),
            std::string::npos);
  for (const double none :
       {std::numeric_limits<double>::quiet_NaN(), std::numeric_limits<double>::infinity()}) {
    certificate.checks.optimality.expected_decrease = none;
    const std::string line = optimality_line(certificate);
    EXPECT_TRUE(line.starts_with("stationarity 1.0e-08 along own gains")) << line;
    EXPECT_EQ(line.find("Newton"), std::string::npos) << line;
  }
}

}  // namespace
}  // namespace conddp
